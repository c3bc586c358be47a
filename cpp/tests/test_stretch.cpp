#include "bodies_support.hpp"

using namespace support;

namespace {

// The rig of (2.1) under Coulomb's law, pulled slowly.
Setup slow_rig(double v_b, double damping, double s) {
  Setup setup = reference_rig();
  setup.structure.law = law("coulomb");
  setup.p[belt_speed] = v_b, setup.p[eta1] = damping, setup.p[eta12] = 2 * damping, setup.p[coupling] = s;
  setup.z = {0.2, v_b, 0.3, -0.1};
  setup.contact = 0;
  return setup;
}

// The same run with every linear piece in steps of its own: what a crossing replaces.
Run<double> step_by_step(const Setup& setup, double t_end, double step) {
  System<double> sys;
  State<double> s{};
  prepare(setup, sys);
  std::copy(setup.z.begin(), setup.z.end(), s.z);
  Machine<double> machine(sys, {1e-12, 1e-12, t_end, true, 25, step, 100000});
  machine.start(s, setup.contact);
  Run<double> out;
  const auto changed = [&](Machine<double>& m, const Mode& before, bool kink) {
    Change<double> c{m.s.t, before.contact, m.mode.contact, kink, {}};
    std::copy(m.s.z, m.s.z + state_count, c.z);
    out.changes.push_back(c);
  };
  machine.run([](const auto&...) {}, changed, [](auto&) {}, [] { return false; });
  out.end = machine.s;
  out.summary = machine.summary;
  return out;
}

// The leg in stick: y'' = -(b3 y + e12 y' + x1 + e1 v_b)/a2 in closed form, and when q first reaches its upper limit.
struct Stick {
  long double p0, p1, a, b, decay, turn, level, slope, s, e1;
  explicit Stick(const Setup& setup) {
    const auto& p = setup.p;
    const long double a2 = p[alpha2], b3 = p[beta3], e12 = p[eta12], v = p[belt_speed];
    e1 = p[eta1], s = p[coupling];
    p1 = -v / b3;
    p0 = -(setup.z[0] + e1 * v + e12 * p1) / b3;
    decay = e12 / (2 * a2), turn = std::sqrt(b3 / a2 - decay * decay);
    a = setup.z[2] - p0, b = (setup.z[3] - p1 + decay * a) / turn;
    level = p[alpha1] * setup.z[0] + e1 * v, slope = p[alpha1] * v;
  }
  long double q(long double t) const {
    const long double c = std::cos(turn * t), r = std::sin(turn * t), by = std::exp(-decay * t);
    const long double y = p0 + p1 * t + by * (a * c + b * r);
    const long double v = p1 + by * ((b * turn - decay * a) * c - (a * turn + decay * b) * r);
    return level + slope * t + s * y + e1 * v;
  }
  // First crossing, by steps of a fiftieth of a turn from where the envelope no more excludes it.
  long double release(long double limit) const {
    const long double size = std::sqrt(a * a + b * b) * (s + e1 * (turn + decay)), rate = slope + s * p1;
    const auto next = [&](long double t) {
      return (limit - level - s * p0 - e1 * p1 - size * std::exp(-decay * t)) / rate;
    };
    long double t = next(0);
    for (int i = 0; i < 100 && t > 0; ++i) t = next(t);
    if (t < 0) t = 0;
    const long double part = 0.02L / turn;
    long double top = t;  // the crossing may hide in the tip of a swing
    for (; q(top) < limit && q(t) < limit; t += part) {
      if (q(t - part) < q(t - 2 * part) || q(t - part) < q(t)) continue;
      long double left = t - 2 * part, right = t;
      for (int i = 0; i < 120; ++i) {
        const long double a1 = (2 * left + right) / 3, a2 = (left + 2 * right) / 3;
        (q(a1) < q(a2) ? left : right) = q(a1) < q(a2) ? a1 : a2;
      }
      top = right;
    }
    long double hi = q(top) >= limit ? top : t, lo = hi - 2 * part;
    for (int i = 0; i < 200; ++i) (q((lo + hi) / 2) < limit ? lo : hi) = (lo + hi) / 2;
    return hi;
  }
};

}  // namespace

TEST_CASE("a long stick of (2.1) ends where its closed form does, however long it lasts") {
  for (const double damping : {0.0, 1e-4, 0.05, 0.6})
    for (const double s : {1.0, 0.6})
      for (const double v : {1e-2, 1e-4, 1e-6, 1e-9, 1e-12}) {
        if (damping == 0 && v < 1e-9) continue;  // the phase itself is lost in rounding
        const Setup setup = slow_rig(v, damping, s);
        const double limit = setup.p[slot("coulomb.static_minus")];
        const Stick stick(setup);
        const long double expected = stick.release(limit);
        const auto r = run<double>(setup, static_cast<double>(expected) + 1, 1e-12);
        INFO("v_b = ", v, ", damping ", damping, ", s ", s, ", steps ", r.summary.steps);
        REQUIRE(!r.changes.empty());
        CHECK(r.changes[0].after == -1);
        const double turns = static_cast<double>(expected * stick.turn);
        CHECK(std::abs(static_cast<double>(r.changes[0].t - expected)) <
              1e-14 * static_cast<double>(expected) + (damping == 0 ? 2e-16 * turns * turns + 1e-9 : 1e-9));
        CHECK(r.summary.steps < (damping > 0 && damping < 0.01 ? 5000 : 400));
      }
}

TEST_CASE("a long stick's end differentiates through the crossing as its closed form does") {
  const double v = 1e-5;
  const Setup setup = slow_rig(v, 0.05, 0.7);
  const int limit = slot("coulomb.static_minus");
  for (const int place : std::array<int, 8>{alpha1, alpha2, beta3, eta1, eta12, coupling, belt_speed, limit}) {
    const auto moved = [&](long double by) {
      Setup one = setup;
      one.p[static_cast<std::size_t>(place)] += static_cast<double>(by);
      return Stick(one).release(one.p[static_cast<std::size_t>(limit)]);
    };
    const double h = 0x1p-10 * setup.p[static_cast<std::size_t>(place)];
    const double expected = slope_at_zero(moved, static_cast<long double>(h));
    const auto seeded = run<Dual<4>>(setup, 1.1 * static_cast<double>(moved(0)), 1e-12,
                                     [&](auto& p, auto&) { p[place].set_derivative(1, 1.0); });
    REQUIRE(!seeded.changes.empty());
    CHECK(seeded.summary.steps < 500);
    INFO("place ", place);
    const double size = std::max(std::abs(expected), 1e-6 * static_cast<double>(moved(0)));  // alpha2 hardly moves it
    CHECK(std::abs(seeded.changes[0].t.derivative(1) - expected) < 1e-8 * size);
  }
}

TEST_CASE("stretches crossed at once are what steps would make of them, in stick and in slip") {
  for (const double damping : {0.02, 0.1})
    for (const double v : {3e-4, -2e-3, 0.05}) {
      Setup setup = slow_rig(v, damping, 0.7);
      setup.z = {0.1, 0.0, 0.2, 0.1};
      setup.contact = 2;
      for (const int saturated : {0, 1}) {
        Setup one = setup;
        if (saturated != 0) {  // rides the belt's back: steady sliding in the end
          one.structure.rig = RigKind::block_on_belt;
          one.p[stiffness] = 1, one.z[2] = one.z[3] = 0;
          one.p[slot("coulomb.static_minus")] = one.p[slot("coulomb.kinetic_minus")];
        }
        const double t_end = 3000 / std::sqrt(damping);
        const auto quick = run<double>(one, t_end, 1e-12), slow = step_by_step(one, t_end, 0.4);
        INFO("v_b = ", v, ", damping ", damping, ": ", quick.changes.size(), " changes");
        REQUIRE(quick.changes.size() == slow.changes.size());
        CHECK(quick.summary.steps < slow.summary.steps / 4);
        for (std::size_t i = 0; i < quick.changes.size(); ++i)
          CHECK(close(quick.changes[i].t, slow.changes[i].t, 1e-10));
        for (int k = 0; k < 4; ++k) CHECK(close(quick.end.z[k], slow.end.z[k], 1e-9));
      }
    }
}
