#include "stickslip/sweep.hpp"

#include <chrono>
#include <cstddef>
#include <cstring>
#include <limits>
#include <new>

#include "stickslip/kernel.hpp"

namespace stickslip {

namespace {

using namespace stickslip_abi;

struct Shared {
  long next = 0;
  long members;
  int points;
  SweepResult* out;
  bool (*interrupted)();
  std::chrono::steady_clock::time_point asked = std::chrono::steady_clock::now();
};

// Is an interrupt pending? Looked up at most every 20 ms.
bool stops(Shared& s) {
  const auto now = std::chrono::steady_clock::now();
  if (now - s.asked < std::chrono::milliseconds(20)) return false;
  s.asked = now;
  return s.interrupted();
}

long take(void* context) {
  Shared& s = *static_cast<Shared*>(context);
  if (!s.out->interrupted && stops(s)) s.out->interrupted = true;
  return s.out->interrupted || s.next == s.members ? -1 : s.next++;
}

void done(void* context, long member, const SweepRow& row, const double* points) {
  Shared& s = *static_cast<Shared*>(context);
  double* to = s.out->rows.data() + member * sweep_row_size;
  std::memcpy(to, &row, sizeof row);
  const long kept = s.points == 0                                ? 0
                    : static_cast<long>(row.releases) < s.points ? static_cast<long>(row.releases)
                                                                 : s.points;
  double* p = s.out->points.data() + member * s.points * 5;
  for (long k = 0; k < kept; ++k) {  // the ring, newest first
    const long slot = (static_cast<long>(row.releases) - 1 - k) % s.points;
    std::memcpy(p + k * 5, points + slot * 5, 5 * sizeof(double));
  }
}

// Memory for a kernel, kept by the thread: to map it anew for every batch costs as much as a few members.
class Workspace {
 public:
  Workspace() : at_(::operator new(dispatch::sweep_workspace(), line)) {}
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
  ~Workspace() { ::operator delete(at_, line); }
  void* get() const { return at_; }

 private:
  static constexpr std::align_val_t line{128};
  void* at_;
};

}  // namespace

SweepResult sweep(SweepRequest request, long members, bool (*interrupted)()) {
  thread_local const Workspace workspace;
  SweepResult out;
  out.rows.resize(static_cast<std::size_t>(members) * sweep_row_size);
  out.points.assign(static_cast<std::size_t>(members) * static_cast<std::size_t>(request.points) * 5,
                    std::numeric_limits<double>::quiet_NaN());
  Shared shared{.members = members, .points = request.points, .out = &out, .interrupted = interrupted};
  request.context = &shared;
  request.take = take;
  request.done = done;
  dispatch::sweep(request, workspace.get());
  return out;
}

}  // namespace stickslip
