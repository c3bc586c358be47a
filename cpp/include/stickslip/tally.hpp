// What a sweep observes of a trajectory while it runs; nothing of it is stored.
#pragma once

#include "stickslip/over_step.hpp"
#include "stickslip/piece.hpp"
#include "stickslip/sweep_request.hpp"

namespace stickslip::inline STICKSLIP_ISA {

struct Tally {
  SweepRow row;
  double points[max_sweep_points][5];
};

inline void clear(Tally& tally) {
  tally.row = SweepRow{};
  for (int i = 0; i < 4; ++i) {
    tally.row.state_min[i] = std::numeric_limits<double>::infinity();
    tally.row.state_max[i] = -std::numeric_limits<double>::infinity();
  }
}

// Work of friction on the sliding contact, integral of T v_w: T is what the motion says, where nothing else acts.
inline double work(const Rig<double>& r, const Strided* z, int order, double h, double belt) {
  return integral(0.0, h, [&](double t) {
    double v[4];
    for (int i = 0; i < 4; ++i) v[i] = at(z[i], order, t);
    const double friction = -(r.a1 * (slope_at(z[1], order, t) + r.kx * v[0]) + bracket(r, v[1], v[2], v[3]));
    return friction * (v[1] - belt);
  });
}

// The same of a piece with effects, which has the series of both.
inline double work(const Strided& friction, const Strided& v_w, int order, double h) {
  return integral(0.0, h, [&](double t) { return at(friction, order, t) * at(v_w, order, t); });
}

// A step of length h of a piece, seen from `after` on.
inline void observe_step(Tally& tally, std::uint32_t what, const Rig<double>& r, const Strided* z, int contact,
                         int order, double h) {
  if ((what & ob_range) != 0)
    for (int i = 0; i < (r.two ? 4 : 2); ++i)
      widen(tally.row.state_min[i], tally.row.state_max[i], z[i], order, 0.0, h);
  if ((what & ob_dissipated) != 0 && contact != 0) tally.row.dissipated += work(r, z, order, h, r.v_b);
}

// A change of the contact mode, seen from `after` on.
inline void observe_transition(Tally& tally, int points, int before, int now, double t, const double* state) {
  SweepRow& row = tally.row;
  row.transitions += 1;
  if (now == 0) return;
  row.slips += before == 0 ? 1 : 0;
  if (row.releases > 0) {
    const double interval = t - row.last_release;
    row.interval_squares += interval * interval;
  } else {
    row.first_release = t;
  }
  row.last_release = t;
  if (points > 0) {
    double* p = tally.points[static_cast<long>(row.releases) % points];
    p[0] = t;
    for (int i = 0; i < 4; ++i) p[i + 1] = state[i];
  }
  row.releases += 1;
}

}  // namespace stickslip::inline STICKSLIP_ISA
