#include "bodies_support.hpp"

using namespace support;

namespace {

// f(u) by its tape, as a series about u(0) of u(t) = 0.7 + 0.3 t - 0.2 t^2, against f(u(h)).
template <class T>
void check_operation(Op op, double exponent, double tolerance) {
  Sheet sheet;
  const int u = sheet.put(Op::u), p = sheet.put(Op::parameter, 0);
  const int half = sheet.put(Op::multiply, u, sheet.put(Op::parameter, 1));  // linear: folded
  const int curved = sheet.put(Op::add, half, sheet.put(Op::multiply, u, half));
  const int out = is_binary(op) ? sheet.put(op, curved, p) : sheet.put(op, curved);
  const double parameters[] = {exponent, 0.5};
  const T numbers[] = {T(exponent), T(0.5)};
  T series[series_size] = {};
  for (T& one : series) one = T(0.0);
  series[0] = T(0.7), series[1] = T(0.3), series[2] = T(-0.2);
  const BranchTape branch = sheet.view(out);
  Arena count;
  Tape<T> tape;
  tape.place(count, branch, parameters);
  const std::unique_ptr<void, decltype(&std::free)> memory(std::aligned_alloc(64, count.used), std::free);
  Arena arena{static_cast<std::byte*>(memory.get()), 0};
  tape.place(arena, branch, parameters);
  tape.reads = {numbers, series, nullptr, nullptr, nullptr, 1.0, false};
  link(tape, &out, 1, -1);
  constexpr int order = 25;
  T c[series_size];
  for (int k = 0; k <= order; ++k) {
    run(tape.inner, tape.inners, k);
    c[k] = coefficient(tape, out, k);
  }
  for (const double h : {0.0, 0.05, -0.08}) {
    const T at = evaluate(series, 2, T(h)), x = at * 0.5 + at * (at * 0.5);
    const int side = op == Op::maximum || op == Op::minimum ? (value(x) > exponent ? 1 : -1) : 1;
    const T expected = apply(op, x, T(exponent), side), got = evaluate(c, order, T(h));
    INFO("operation ", static_cast<int>(op), " at ", h);
    CHECK(close(static_cast<double>(value(got - expected)), 0.0, tolerance));
  }
}

template <class T>
void check_operations(double tolerance) {
  for (const Op op :
       {Op::add, Op::subtract, Op::multiply, Op::divide, Op::negate, Op::absolute, Op::minimum, Op::maximum, Op::sign,
        Op::exponential, Op::logarithm, Op::square_root, Op::sine, Op::cosine, Op::tangent, Op::tanh, Op::asinh})
    check_operation<T>(op, 1.7, tolerance);
  for (const double p : {-2.0, -0.5, 0.0, 0.5, 1.0, 1.3, 2.0, 3.0, 5.0, 12.0})
    check_operation<T>(Op::power, p, tolerance);
}

// Coulomb's law with its own numbers for each contact: parameters kinetic, static, speed of the belt.
struct Chain {
  Sheet law, belt;
  LawTape laws[3];
  int speed_of[3] = {0, 0, 0};
  double begins[1] = {0.0};
  BranchTape piece{};
  SpeedTape speed{};
  Bodies bodies{};
  std::vector<double> values;

  Chain(int n, double coupling) {
    const int kinetic = law.put(Op::parameter, 0), limit = law.put(Op::parameter, 1);
    const BranchTape branch = law.view(kinetic, limit);
    for (LawTape& one : laws) one = {{branch, branch}, 0};
    const int steady = belt.put(Op::parameter, 2);
    piece = belt.view(steady);
    speed = {begins, &piece, 1};
    bodies = {n, n, 1, 3, 0, laws, speed_of, &speed};
    const BodiesLayout at = layout_of(bodies);
    values.assign(static_cast<std::size_t>(at.size), 0.0);
    const auto put = [&](int place, double x) { values[static_cast<std::size_t>(place)] = x; };
    for (int i = 0; i < n; ++i) {
      put(at.M + i * (n + 1), 1.0 + 0.3 * i);
      put(at.D + i * (n + 1), 1.0);
      put(at.K + i * (n + 1), 1.0 + coupling * ((i > 0) + (i + 1 < n)));
      if (i + 1 < n) put(at.K + i * n + i + 1, -coupling);
      if (i > 0) put(at.K + i * n + i - 1, -coupling);
      put(at.initial + n + i, n == 1 ? 0.2 : 0.05 * (i + 1));
      put(at.initial + i, 0.13 * i - 0.07 * i * i);
    }
    put(at.parameters, 0.5);
    put(at.parameters + 1, 1.0);
    put(at.parameters + 2, 0.2);
  }
};

template <class T>
void check_coulomb_again(double tolerance, const Chain& one = Chain(1, 0.0)) {
  const auto r = run_bodies<T>(one.bodies, one.values, 40.0, 1e-15, [](auto*) {});
  const long double v_b = 0.2, stick = 1 / v_b, slip = 2 * (std::acos(-1.0L) - std::atan(0.5L / v_b));
  REQUIRE(r.changes.size() == 8);
  for (std::size_t i = 0; i < r.changes.size(); ++i) {
    const long double before = i == 0 ? 0.0L : static_cast<long double>(value(r.changes[i - 1].t));
    const long double lasted = static_cast<long double>(value(r.changes[i].t)) - before;
    CHECK(std::abs(static_cast<double>(lasted - (i % 2 == 0 ? stick : slip))) < tolerance);
  }
}

}  // namespace

TEST_CASE("bodies: the series of every operation is that of the function") {
  check_operations<double>(1e-12);
  check_operations<long double>(1e-14);
  check_operations<Dual<4>>(1e-12);
}

TEST_CASE("bodies: Coulomb's block on a belt in closed form, in every number type") {
  check_coulomb_again<double>(3e-14);
  check_coulomb_again<Dual<4>>(3e-14);
  check_coulomb_again<long double>(3e-17);
}

TEST_CASE("bodies: a belt in many equal pieces moves as one, and its corners are no chatter") {
  Chain one(1, 0.0);
  std::vector<double> begins;
  for (int i = 0; i < 500; ++i) begins.push_back(0.0701 * i);
  const std::vector<BranchTape> pieces(begins.size(), one.piece);
  one.speed = {begins.data(), pieces.data(), static_cast<int>(begins.size())};
  one.bodies.speed = &one.speed;
  check_coulomb_again<double>(1e-12, one);
}

TEST_CASE("bodies: a chain of three differentiates by matrices, laws, the belt and the start") {
  const Chain chain(3, 0.4);
  const BodiesLayout at = layout_of(chain.bodies);
  const double t_end = 40.0;
  for (const int place : {at.M, at.K + 1, at.K + 4, at.C, at.D + 1, at.force + 2, at.parameters, at.parameters + 1,
                          at.parameters + 2, at.initial, at.initial + 1}) {
    const auto seeded = run_bodies<Dual<4>>(chain.bodies, chain.values, t_end, 1e-13,
                                            [&](Dual<4>* values) { values[place].set_derivative(2, 1.0); });
    CHECK(seeded.changes.size() > 10);
    const long double h = 1e-6L;
    INFO("place ", place);
    std::vector<BodiesRun<long double>> moved;
    for (const long double shift : {-2 * h, -h, h, 2 * h})
      moved.push_back(run_bodies<long double>(chain.bodies, chain.values, t_end, 1e-17,
                                              [&](long double* values) { values[place] += shift; }));
    for (const auto& m : moved) REQUIRE(m.changes.size() == seeded.changes.size());
    const auto slope = [&](auto&& get) {
      return static_cast<double>((8 * (get(moved[2]) - get(moved[1])) - (get(moved[3]) - get(moved[0]))) / (12 * h));
    };
    for (std::size_t i = 0; i < seeded.changes.size(); ++i) {
      const double expected = slope([&](const auto& r) { return r.changes[i].t; });
      CHECK(close(seeded.changes[i].t.derivative(2), expected, 1e-8));
      for (std::size_t k = 0; k < 6; ++k)
        CHECK(
            close(seeded.changes[i].z[k].derivative(2), slope([&](const auto& r) { return r.changes[i].z[k]; }), 1e-8));
    }
    for (std::size_t k = 0; k < 6; ++k)
      CHECK(close(seeded.end[k].derivative(2), slope([&](const auto& r) { return r.end[k]; }), 1e-8));
  }
}

TEST_CASE("bodies: a surface of u alone is a bound on u, found once, with its derivative") {
  // max(3 - 0.5 exp(u/0.1) - exp(u/0.4), 1): the crossing and d/d 0.1 by bisection and perturbation in long double
  const auto root = [](long double shift) {
    long double lo = 0, hi = 1;
    for (int i = 0; i < 200; ++i) {
      const long double u = (lo + hi) / 2;
      (3 - 0.5L * std::exp(u / (0.1L + shift)) - std::exp(u / 0.4L) > 1 ? lo : hi) = u;
    }
    return lo;
  };
  Sheet sheet;
  const int u = sheet.put(Op::u);
  const auto number = [&](int i) { return sheet.put(Op::parameter, i); };
  const int steep = sheet.put(Op::exponential, sheet.put(Op::divide, u, number(0)));
  const int gentle = sheet.put(Op::exponential, sheet.put(Op::divide, u, number(1)));
  const int fall = sheet.put(Op::subtract, number(2), sheet.put(Op::multiply, number(3), steep));
  const int force = sheet.put(Op::maximum, sheet.put(Op::subtract, fall, gentle), number(4));
  const double parameters[] = {0.1, 0.4, 3.0, 0.5, 1.0};
  Dual<4> numbers[5];
  for (int i = 0; i < 5; ++i) numbers[i] = Dual<4>(parameters[i]);
  numbers[0].set_derivative(1, 1.0);
  const BranchTape branch = sheet.view(force);
  Arena count;
  Tape<Dual<4>> tape;
  tape.place(count, branch, parameters);
  const std::unique_ptr<void, decltype(&std::free)> memory(std::aligned_alloc(64, count.used), std::free);
  Arena arena{static_cast<std::byte*>(memory.get()), 0};
  tape.place(arena, branch, parameters);
  Dual<4> series[series_size];
  for (const double at : {0.01, 0.9}) {
    for (Dual<4>& one : series) one = Dual<4>(at);
    tape.reads = {numbers, series, nullptr, nullptr, nullptr, 1.0, false};
    forget_sides(tape);
    link(tape, &force, 1, -1);
    CHECK(tape.surface_count == 0);
    CHECK(tape.outers == 0);
    Interval<Dual<4>> bounds;
    REQUIRE(surface_bounds(tape, force, bounds));
    CHECK(bounds.has_hi == (at < 0.5));
    CHECK(bounds.has_lo == (at > 0.5));
    const Dual<4> crossing = at < 0.5 ? bounds.hi : bounds.lo;
    CHECK(close(crossing.v, static_cast<double>(root(0)), 1e-15));
    CHECK(close(crossing.derivative(1), slope_at_zero(root, 1e-5L), 1e-12));
  }
}

TEST_CASE("bodies: ranges of every operation hold its values, and of u they show where nothing crosses") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-2.0, 3.0);
  for (int trial = 0; trial < 4000; ++trial) {
    const Op op =
        static_cast<Op>(static_cast<int>(Op::add) + trial % (static_cast<int>(Op::count) - static_cast<int>(Op::add)));
    Range a{draw(random), 0}, b{draw(random), 0};
    a.hi = a.lo + std::abs(draw(random)) * 0.5;
    b.hi = trial % 3 == 0 ? (b.lo = std::round(b.lo)) : b.lo + std::abs(draw(random)) * 0.5;
    const Range r = range_of(op, a, b);
    for (int i = 0; i <= 8; ++i)
      for (int k = 0; k <= 8; ++k) {
        const double x = a.lo + (a.hi - a.lo) * i / 8, y = b.lo + (b.hi - b.lo) * k / 8;
        const bool above = op == Op::maximum || op == Op::minimum ? x > y : x > 0;
        const double got = apply(op, x, y, above ? 1 : -1);
        if (std::isnan(got)) continue;
        INFO("operation ", static_cast<int>(op), " at ", x, ", ", y);
        CHECK(got >= r.lo - 1e-12 * std::abs(got));
        CHECK(got <= r.hi + 1e-12 * std::abs(got));
      }
  }
}
