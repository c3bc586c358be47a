// (3.1) as a scan, compiled once for every instruction set (STICKSLIP_ISA names the variant).
//
// A first-order recursion depends on the sample before it, which leaves a processor waiting for one
// addition after the other. Applied m times to itself it depends on the sample m before it:
//     y_n = a^m y_{n-m} + sum_{j<m} a^j w_{n-j},    w_n = k0 (x_n - x_{n-1}) + (k0 + k1) x_{n-1}.
// With m*channels >= 8 a chunk of 8 neighbours in memory needs only results from before the chunk.
// w is formed by differences so that a channel at rest has a derivative of exactly 0 when k1 = -k0.
#include <array>
#include <cstddef>
#include <cstring>

#include "stickslip/filter.hpp"
#include "stickslip/isa.hpp"

namespace stickslip::STICKSLIP_ISA {
namespace {

constexpr std::size_t width = 8;     // doubles in a chunk
constexpr std::size_t history = 16;  // >= (m - 1) * channels whenever m > 1
constexpr std::size_t tile = 1024;   // values of w kept in the first-level cache; a multiple of width

// One register (GCC's and Clang's vector type), and a chunk as the few of them that hold it. Not wider than
// four doubles: rows start anywhere, and 64-byte loads that straddle cache lines measured slower.
constexpr std::size_t lanes = STICKSLIP_LANES < 4 ? STICKSLIP_LANES : 4;
using Register = double __attribute__((vector_size(lanes * sizeof(double))));

struct Chunk {
  static constexpr std::size_t parts = width / lanes;
  Register part[parts];

  explicit Chunk(const double* from) noexcept {
    for (std::size_t r = 0; r < parts; ++r) std::memcpy(&part[r], from + r * lanes, sizeof(Register));
  }
  Chunk() noexcept {
    for (std::size_t r = 0; r < parts; ++r) part[r] = Register{};
  }
  void store(double* to) const noexcept {
    for (std::size_t r = 0; r < parts; ++r) std::memcpy(to + r * lanes, &part[r], sizeof(Register));
  }
  void add(double factor, const Chunk& other) noexcept {
    for (std::size_t r = 0; r < parts; ++r) part[r] += factor * other.part[r];
  }
};

struct Source {
  const double* x;
  std::size_t channels;
  double k0;
  double sum;  // k0 + k1

  double at(std::size_t i) const noexcept {
    const double before = x[i - channels];
    return k0 * (x[i] - before) + sum * before;
  }
  Chunk chunk(std::size_t i) const noexcept {
    const Chunk before(x + i - channels);
    Chunk w(x + i);
    for (std::size_t r = 0; r < Chunk::parts; ++r) w.part[r] = k0 * (w.part[r] - before.part[r]);
    w.add(sum, before);
    return w;
  }
};

// 0*x is 0 for a finite x and NaN otherwise: their sum tells whether all inputs were finite.
struct Poison {
  Chunk many;
  double one = 0.0;

  void take(double x) noexcept { one += 0.0 * x; }
  void take(const double* x) noexcept { many.add(0.0, Chunk(x)); }
  bool none() const noexcept {
    double total = one;
    for (const Register& part : many.part) {
      for (std::size_t l = 0; l < lanes; ++l) total += part[l];
    }
    return total == 0.0;
  }
};

// Fills w[0, count) with w of the flat indices first, first+1, ...
inline void fill(const Source& source, std::size_t first, std::size_t count, double* __restrict w,
                 Poison& poison) noexcept {
  std::size_t i = 0;
  for (; i + width <= count; i += width) {
    source.chunk(first + i).store(w + i);
    poison.take(source.x + first + i);
  }
  for (; i < count; ++i) {
    w[i] = source.at(first + i);
    poison.take(source.x[first + i]);
  }
}

template <std::size_t M>
constexpr std::array<double, M + 1> powers(double a) noexcept {
  std::array<double, M + 1> p{};
  p[0] = 1.0;
  for (std::size_t j = 1; j <= M; ++j) p[j] = p[j - 1] * a;
  return p;
}

// The M-fold recursion on one tile: outputs y[first, first + count) from w[-history, count).
// `Carry`: the lag M*channels is the chunk itself, and the last chunk stays in registers.
template <std::size_t M, bool Carry>
inline void recur(const double* w, double* __restrict y, std::size_t first, std::size_t count, std::size_t channels,
                  const std::array<double, M + 1>& p, Chunk& last) noexcept {
  const std::size_t lag = M * channels;
  const std::size_t chunked = Carry || first >= lag ? count / width * width : 0;
  std::size_t i = 0;
  for (; i < chunked; i += width) {
    Chunk s(w + i);
    for (std::size_t j = 1; j < M; ++j) s.add(p[j], Chunk(w + i - j * channels));
    if constexpr (!Carry) last = Chunk(y + (first + i - lag));
    s.add(p[M], last);
    s.store(y + first + i);
    last = s;
  }
  for (; i < count; ++i) {
    double s = w[i];
    for (std::size_t j = 1; j < M; ++j) s += p[j] * w[i - j * channels];
    y[first + i] = s + (first + i >= lag ? p[M] * y[first + i - lag] : 0.0);
  }
}

template <std::size_t M, bool Carry>
bool run(const Source& source, double* __restrict y, std::size_t total, double a) noexcept {
  const std::size_t channels = source.channels;
  const auto p = powers<M>(a);
  alignas(64) std::array<double, history + tile> buffer{};
  double* const w = buffer.data() + history;
  Poison poison;
  Chunk last;
  for (std::size_t k = 0; k < channels; ++k) {
    y[k] = 0.0;
    poison.take(source.x[k]);
  }
  // Without Carry the first tile goes value by value up to where results of M samples ago exist.
  std::size_t end = Carry ? channels + tile : M * channels;
  for (std::size_t first = channels; first < total; first = end, end += tile) {
    const std::size_t count = (total < end ? total : end) - first;
    if (count == 0) continue;
    fill(source, first, count, w, poison);
    recur<M, Carry>(w, y, first, count, channels, p, last);
    std::memmove(buffer.data(), buffer.data() + count, history * sizeof(double));
  }
  return poison.none();
}

// Many channels: the rows themselves are long enough, and y is read back as it was written.
bool run_rows(const Source& source, double* __restrict y, std::size_t total, double a) noexcept {
  const std::size_t channels = source.channels;
  Poison poison;
  for (std::size_t k = 0; k < channels; ++k) {
    y[k] = 0.0;
    poison.take(source.x[k]);
  }
  for (std::size_t row = channels; row < total; row += channels) {
    std::size_t k = row;
    for (; k + width <= row + channels; k += width) {
      Chunk w = source.chunk(k);
      w.add(a, Chunk(y + k - channels));
      w.store(y + k);
      poison.take(source.x + k);
    }
    for (; k < row + channels; ++k) {
      y[k] = source.at(k) + a * y[k - channels];
      poison.take(source.x[k]);
    }
  }
  return poison.none();
}

}  // namespace

bool first_order(const double* x, double* y, std::size_t n, std::size_t channels, const Recursion& c) noexcept {
  if (n == 0 || channels == 0) return true;
  const Source source{x, channels, c.k0, c.k0 + c.k1};
  const std::size_t total = n * channels;
  switch (channels) {
    case 1: return run<8, true>(source, y, total, c.a);
    case 2: return run<4, true>(source, y, total, c.a);
    case 3: return run<4, false>(source, y, total, c.a);
    case 4: return run<2, true>(source, y, total, c.a);
    case 5:
    case 6:
    case 7: return run<2, false>(source, y, total, c.a);
    case 8: return run<1, true>(source, y, total, c.a);
    default: return run_rows(source, y, total, c.a);
  }
}

}  // namespace stickslip::STICKSLIP_ISA
