// The series of a piece: every coordinate, every law's state, the force that holds what sticks.
#pragma once

#include "stickslip/bodies/push.hpp"
#include "stickslip/bodies/short_motion.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr int most_forces = 128;     // contacts and pushes
constexpr int polynomial_order = 4;  // enough where all is stuck on belts whose speed is linear in t

// u = |v| of a contact in slip.
template <class T>
T speed_coefficient(const BodiesSystem<T>& sys, int j, int k) {
  const Contact<T>& c = sys.contact[j];
  T s(0.0);
  if (k == 0 && c.leaving) return s;
  for (int i = 0; i < sys.n; ++i) add_product(s, sys.D(j)[i], sys.v[i * series_size + k]);
  if (c.speed >= 0) s = s - sys.V[c.speed * series_size + k];
  return s * static_cast<double>(c.mode);
}

// Coefficient k of the forces and rates of all laws and pushes, u known.
template <class T>
void laws_next(BodiesSystem<T>& sys, int k, bool rates) {
  for (int j = 0; j < sys.contacts; ++j) {
    Contact<T>& c = sys.contact[j];
    if (c.mode != sticks) sys.u[j * series_size + k] = speed_coefficient(sys, j, k);
    Tape<T>& tape = tape_of(c);
    run(tape.inner, tape.inners, k);
    if (!c.linear) {
      const double sign = c.compliant[c.mode > 0] ? 1.0 : c.mode;
      sys.force[j * series_size + k] = coefficient(tape, tape.formulas->force, k) * sign;
    }
    if (!rates) continue;
    for (int i = 0; i < c.states; ++i)
      sys.z[(c.first_state + i) * series_size + k + 1] =
          coefficient(tape, tape.formulas->rates[i], k) * inverse<T>(k + 1);
  }
  for (int e = 0; e < sys.pushes; ++e) push_next(sys, e, k, rates);
}

// The recurrence, N coordinates (0: as many as there are).
template <int N, class T>
void expand_motion(BodiesSystem<T>& sys, const int* curved, int count, int order) {
  if constexpr (N > 0) {
    if (is_short(sys, count)) {
      count == 0 ? expand_short<N, false>(sys, 0, order) : expand_short<N, true>(sys, curved[0], order);
      for (int j = 0; j < sys.contacts; ++j) {
        const bool known = sys.contact[j].mode == sticks || (count > 0 && j == curved[0]);
        for (int k = 0; !known && k < order; ++k) sys.u[j * series_size + k] = speed_coefficient(sys, j, k);
      }
      return;
    }
  }
  for (int k = 0; k < order; ++k) {
    laws_next(sys, k, true);
    motion_next<N>(sys, curved, count, k);
  }
}
template <class T>
void expand_motion(BodiesSystem<T>& sys, const int* curved, int count, int order) {
  switch (sys.n) {
    case 1: return expand_motion<1>(sys, curved, count, order);
    case 2: return expand_motion<2>(sys, curved, count, order);
    case 3: return expand_motion<3>(sys, curved, count, order);
    case 4: return expand_motion<4>(sys, curved, count, order);
    case 5: return expand_motion<5>(sys, curved, count, order);
    case 6: return expand_motion<6>(sys, curved, count, order);
    case 7: return expand_motion<7>(sys, curved, count, order);
    case 8: return expand_motion<8>(sys, curved, count, order);
    default: return expand_motion<0>(sys, curved, count, order);
  }
}

// Does a root, or a power that is not whole, begin at 0? Of a speed there is no series then; a piece that moves the rig has
// one fitted (onset.hpp).
template <class T>
bool has_power_of_zero(const Tape<T>& tape) {
  for (int i = 0; i < tape.inners; ++i)
    if (tape.inner[i].code == Code::power && of_zero(tape.inner[i])) return true;
  return false;
}

// Prescribed speeds, which hang on t alone, to one order more than the rest, and where they lead.
template <class T>
void expand_speeds(BodiesSystem<T>& sys, int order) {
  for (int s = 0; s < sys.speeds; ++s) {
    Tape<T>& tape = sys.rail[s].piece[sys.rail[s].now];
    T *V = sys.V + s * series_size, *x = sys.x + s * series_size;
    if (sys.rail[s].steady) {
      if (!sys.rail[s].filled)
        for (int k = 0; k < series_size; ++k) {
          V[k] = k == 0 ? coefficient(tape, tape.formulas->force, 0) : T(0.0);
          if (k > 0) x[k] = V[k - 1];
        }
      sys.rail[s].filled = true;
      continue;
    }
    for (int k = 0; k <= order + 1; ++k) {
      run(tape.inner, tape.inners, k);
      V[k] = coefficient(tape, tape.formulas->force, k);
      if (k == 0 && has_power_of_zero(tape)) V[0] = T(std::numeric_limits<double>::quiet_NaN());
      if (k <= order) x[k + 1] = V[k] * inverse<T>(k + 1);
    }
  }
}

// All series from their first coefficients, which the caller has set: t, q, q', z, x and the dwell.
template <class T>
void expand_bodies(BodiesSystem<T>& sys, int order) {
  int curved[most_forces] = {};
  int count = 0;
  for (int j = 0; j < sys.contacts; ++j)
    if (!sys.contact[j].linear) curved[count++] = j;
  for (int e = 0; e < sys.pushes; ++e)
    if (sys.push[e].moves) curved[count++] = sys.contacts + e;
  expand_speeds(sys, order);
  expand_motion(sys, curved, count, order);
  laws_next(sys, order, false);
  for (int h = 0; h < sys.stuck_count; ++h)
    for (int k = 0; k <= order; ++k)
      sys.friction[sys.stuck[h] * series_size + k] = holding_force(sys, h, curved, count, k);
  for (int j = 0; j < sys.contacts; ++j) {
    Contact<T>& c = sys.contact[j];
    for (int s = 0; s < 2; ++s) {
      if (c.mode != sticks && s != (c.mode > 0)) continue;
      Tape<T>& tape = c.tape[s];
      expand_surfaces(tape, watched_order(sys, j, tape, order), order);
      if (c.mode != sticks) continue;
      T* margin = sys.margin + (2 * j + s) * series_size;  // of T above -limit_minus, below limit_plus
      const T* friction = sys.friction + j * series_size;
      for (int k = 0; k <= order; ++k)
        margin[k] = coefficient(tape, tape.formulas->limit, k) + (s == 0 ? friction[k] : -friction[k]);
    }
  }
  for (int e = 0; e < sys.pushes; ++e)
    expand_surfaces(sys.push[e].tape, watched_order(sys, sys.push[e].tape, order), order);
}

}  // namespace stickslip::inline STICKSLIP_ISA
