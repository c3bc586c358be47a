#include "support.hpp"

using namespace support;

namespace {

using Z = std::array<double, 4>;

// (2.1) with T = sgn(v_w) R, written out; the block on a belt is m x1'' = -k x1 - c x1' - T.
Z field(const Setup& s, int contact, double friction, const Z& z) {
  const auto& p = s.p;
  const auto [x1, x2, y1, y2] = z;
  const double pull = contact * friction;
  if (s.structure.rig == RigKind::block_on_belt) {
    const double a = contact == 0 ? 0.0 : (-p[stiffness] * x1 - p[eta1] * x2 - pull) / p[alpha1];
    return {x2, a, 0, 0};
  }
  const double a = contact == 0 ? 0.0 : -x1 - (p[eta1] * (x2 + y2) + p[coupling] * y1 + pull) / p[alpha1];
  return {x2, a, y2, (-p[beta3] * y1 - p[eta12] * y2 - x1 - p[eta1] * x2) / p[alpha2]};
}

double friction_of(const Setup& s, int contact, double u) {
  Parameters<double> p;
  std::copy(s.p.begin(), s.p.end(), p.p);
  return magnitude(branch(s.structure.law, p, contact), u);
}

// The series of a piece satisfies the equation of motion, and does not forget where it started.
void check_piece(const Setup& s, int contact, bool saturated, double u) {
  System<double> sys;
  prepare(s, sys);
  Mode mode;
  mode.contact = contact;
  mode.saturated = saturated;
  State<double> state{};
  const bool two = s.structure.rig == RigKind::two_degree;
  const Z start{0.12, s.p[belt_speed] + contact * u, two ? -0.2 : 0.0, two ? 0.15 : 0.0};
  std::copy(start.begin(), start.end(), state.z);
  static Piece<double> piece;
  double linear_step = 0;
  const int order = expand(sys, mode, state, 25, piece, linear_step);
  const double* series[] = {piece.s.x1, piece.s.x2, piece.s.y1, piece.s.y2};
  for (const double t : {0.0, 0.001, 0.004, 0.008}) {
    Z z{};
    for (std::size_t i = 0; i < 4; ++i) z[i] = evaluate(series[i], order, t);
    if (t == 0.0) CHECK(z == start);
    const Z expected = field(s, contact, friction_of(s, contact, std::abs(z[1] - s.p[belt_speed])), z);
    INFO("contact ", contact, " saturated ", saturated, " law ", static_cast<int>(s.structure.law), " t ", t);
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(evaluate_slope(series[i], order, t) == doctest::Approx(expected[i]).epsilon(1e-12).scale(1));
    if (contact == 0) {
      const auto& p = s.p;
      const double q = two ? p[alpha1] * z[0] + p[eta1] * (p[belt_speed] + z[3]) + p[coupling] * z[2]
                           : p[stiffness] * z[0] + p[eta1] * p[belt_speed];
      CHECK(evaluate(piece.q, order, t) == doctest::Approx(q).epsilon(1e-13));
    }
  }
}

}  // namespace

TEST_CASE("rig: every piece of every law satisfies (2.1)") {
  for (const int kind : {law("paper"), law("coulomb"), law("hyperbolic")}) {
    for (const double v_b : {0.1, -0.1, 0.0}) {
      for (const double s : {1.0, -1.0}) {
        Setup setup = reference_rig();
        setup.structure.law = kind;
        setup.p[belt_speed] = v_b;
        setup.p[coupling] = s;
        check_piece(setup, 0, false, 0.0);
        for (const int contact : {-1, 1}) {
          check_piece(setup, contact, false, 0.12);
          if (kind == law("paper")) check_piece(setup, contact, true, 0.35);
        }
      }
    }
  }
}

TEST_CASE("rig: every piece of the block on a belt satisfies its equation") {
  for (const int kind : {law("paper"), law("coulomb"), law("hyperbolic")}) {
    Setup setup = reference_rig();
    setup.structure.rig = RigKind::block_on_belt;
    setup.structure.law = kind;
    setup.p[alpha1] = 2.5, setup.p[stiffness] = 7, setup.p[eta1] = 0.3;
    for (const int contact : {-1, 0, 1}) check_piece(setup, contact, false, 0.1);
  }
}

TEST_CASE("rig: the series of each piece carry derivatives by the start and by the parameters") {
  for (const int kind : {law("paper"), law("hyperbolic"), law("coulomb")}) {
    for (const int contact : {-1, 0, 1}) {
      const auto speed_after = [&](const auto& x) {
        using T = std::decay_t<decltype(x[0])>;
        System<T> sys;
        Setup setup = reference_rig();
        setup.structure.law = kind;
        sys.structure = setup.structure;
        for (int i = 0; i < parameter_count; ++i) sys.p[i] = T(setup.p[static_cast<std::size_t>(i)]);
        sys.p[alpha1] = x[0];
        sys.p[eta12] = x[1];
        sys.p[belt_speed] = x[2];
        build(sys);
        Mode mode;
        mode.contact = contact;
        State<T> state{};
        state.z[0] = x[3];
        state.z[1] = contact == 0 ? x[2] : T(x[2] + 0.1 * contact);
        state.z[2] = x[3] * 0.5;
        state.z[3] = T(0.1);
        std::vector<Piece<T>> piece(1);
        Real<T> step(0.0);
        const int order = expand(sys, mode, state, 16, piece[0], step);
        const Real<T> h(0.01);
        T sum = evaluate(piece[0].s.x2, order, h) + evaluate(piece[0].s.y2, order, h);
        sum = sum + evaluate(piece[0].s.x1, order, h) * 3.0 + evaluate(piece[0].s.y1, order, h);
        return contact == 0 ? T(sum + evaluate(piece[0].q, order, h)) : sum;
      };
      check_derivatives<4>(speed_after, std::array<double, 4>{16, 0.2, 0.1, 0.2}, 1e-10);
    }
  }
}

TEST_CASE("rig: without friction the energy falls at eta1 (x2 + y2)^2 + (eta12 - eta1) y2^2") {
  Setup setup = reference_rig();
  setup.structure.law = law("coulomb");
  for (const int slot : {slot("coulomb.kinetic_minus"), slot("coulomb.kinetic_plus")})
    setup.p[static_cast<std::size_t>(slot)] = 0;
  System<double> sys;
  prepare(setup, sys);
  static Piece<double> piece;
  double step = 0;
  State<double> state{{0.3, -0.2, 0.1, 0.4}, 0.0};
  Mode mode;
  mode.contact = -1;
  const int order = expand(sys, mode, state, 25, piece, step);
  const auto& p = setup.p;
  const auto energy = [&](double t) {
    const double x1 = evaluate(piece.s.x1, order, t), x2 = evaluate(piece.s.x2, order, t);
    const double y1 = evaluate(piece.s.y1, order, t), y2 = evaluate(piece.s.y2, order, t);
    return (p[alpha1] * (x1 * x1 + x2 * x2) + p[alpha2] * y2 * y2 + p[beta3] * y1 * y1) / 2 + x1 * y1;
  };
  double lost = 0;  // Gauss's rule of five points on eight stretches
  constexpr double node[] = {0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr double weight[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  for (int i = 0; i < 8; ++i) {
    for (int g = -2; g <= 2; ++g) {
      const double t = step / 8 * (i + 0.5 + 0.5 * (g < 0 ? -1 : 1) * node[std::abs(g)]);
      const double x2 = evaluate(piece.s.x2, order, t), y2 = evaluate(piece.s.y2, order, t);
      lost += step / 16 * weight[std::abs(g)] * (p[eta1] * (x2 + y2) * (x2 + y2) + (p[eta12] - p[eta1]) * y2 * y2);
    }
  }
  CHECK(energy(0.0) - energy(step) == doctest::Approx(lost).epsilon(1e-10));
  CHECK(lost > 1e-3);
}

TEST_CASE("rig: the series of a linear piece is at machine precision over its whole step") {
  const Setup setup = reference_rig();
  System<double> sys;
  System<long double> fine;
  prepare(setup, sys);
  prepare(setup, fine);
  for (const int contact : {0, 1}) {
    Mode mode;
    mode.contact = contact;
    State<double> a{{0.2, 0.1, -0.2, 0.3}, 0.0};
    State<long double> b{{0.2L, 0.1, -0.2L, 0.3L}, 0.0};
    for (std::size_t i = 0; i < 4; ++i) b.z[i] = static_cast<long double>(a.z[i]);
    static Piece<double> piece;
    static Piece<long double> small;
    double h = 0;
    const int order = expand(sys, mode, a, 25, piece, h);
    for (int i = 0; i < 64; ++i) {  // the same in steps of h/64
      long double unused = 0, z[state_count];
      expand(fine, mode, b, 25, small, unused);
      piece_state(fine, mode, small, b, order, static_cast<long double>(h) / 64, z);
      std::copy(z, z + state_count, b.z);
    }
    CHECK(evaluate(piece.s.x1, order, h) == doctest::Approx(static_cast<double>(b.z[0])).epsilon(4e-15));
    CHECK(evaluate(piece.s.y2, order, h) == doctest::Approx(static_cast<double>(b.z[3])).epsilon(4e-15));
  }
}
