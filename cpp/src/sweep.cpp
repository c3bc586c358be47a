#include "stickslip/sweep.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstring>
#include <limits>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#include "stickslip/kernel.hpp"

namespace stickslip {

namespace {

using namespace stickslip_abi;

struct Shared {
  std::atomic<long> next{0};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::condition_variable finished;
  int running = 0;
  long members;
  int points;
  SweepResult* out;
  bool (*interrupted)() = nullptr;  // asked between members where no other thread waits to ask
  std::chrono::steady_clock::time_point asked = std::chrono::steady_clock::now();
};

constexpr std::chrono::milliseconds patience{20};

// Is an interrupt pending? Looked up at most every 20 ms.
bool stops(Shared& s) {
  if (s.interrupted == nullptr) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now - s.asked < patience) return false;
  s.asked = now;
  return s.interrupted();
}

long take(void* context) {
  Shared& s = *static_cast<Shared*>(context);
  if (s.stop.load(std::memory_order_relaxed)) return -1;
  if (stops(s)) {
    s.stop = s.out->interrupted = true;
    return -1;
  }
  const long member = s.next.fetch_add(1, std::memory_order_relaxed);
  return member < s.members ? member : -1;
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

void work(const SweepRequest& request) {
  thread_local const Workspace workspace;
  dispatch::sweep(request, workspace.get());
}

// In threads of its own, while this one waits for an interrupt.
void work_in(int threads, const SweepRequest& request, Shared& shared, bool (*interrupted)()) {
  shared.running = threads;
  std::vector<std::thread> pool;
  for (int i = 0; i < threads; ++i) {
    pool.emplace_back([&] {
      work(request);
      const std::lock_guard lock(shared.mutex);
      --shared.running;
      shared.finished.notify_one();
    });
  }
  {
    std::unique_lock lock(shared.mutex);
    while (!shared.finished.wait_for(lock, patience, [&] { return shared.running == 0; })) {
      lock.unlock();
      if (!shared.stop.load() && interrupted()) shared.stop = shared.out->interrupted = true;
      lock.lock();
    }
  }
  for (std::thread& thread : pool) thread.join();
}

}  // namespace

SweepResult sweep(SweepRequest request, long members, int threads, bool (*interrupted)()) {
  SweepResult out;
  out.rows.resize(static_cast<std::size_t>(members) * sweep_row_size);
  out.points.assign(static_cast<std::size_t>(members) * static_cast<std::size_t>(request.points) * 5,
                    std::numeric_limits<double>::quiet_NaN());
  Shared shared;
  shared.members = members;
  shared.points = request.points;
  shared.out = &out;
  request.context = &shared;
  request.take = take;
  request.done = done;
  if (threads == 1) {
    shared.interrupted = interrupted;
    work(request);
  } else {
    work_in(threads, request, shared, interrupted);
  }
  return out;
}

}  // namespace stickslip
