// Decoders, readers and engines with allocations that fail: soak_allocations [--minutes M]
// [NAME...].
//
// Each scenario is run with the n-th allocation failing, for n from the first to the last it makes,
// then with every n-th failing. Each run ends in the same result, an Error or std::bad_alloc; an
// engine that threw is used further and stays finite; and the same scenario without failures gives
// the same bytes afterwards.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <new>
#include <string>
#include <vector>

#include <wayfare/io/mcap.hpp>

#include "abuse/decode_streams.hpp"
#include "abuse/graph_cases.hpp"
#include "abuse/io_readers.hpp"
#include "abuse/slam_localisation_support.hpp"
#include "abuse/slam_radar_support.hpp"
#include "abuse/slam_support.hpp"

// Eigen's matrices come from malloc: the linker gives calls of our objects to __wrap_malloc.
extern "C" void* __real_malloc(std::size_t size);

namespace {

/// Allocations until one fails, and then how many until the next; negative: none fails.
std::atomic<long> failing_in{-1}, failing_every{0};
std::atomic<long> allocations{0};

bool fails() {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (failing_in.load(std::memory_order_relaxed) < 0) return false;
  if (failing_in.fetch_sub(1, std::memory_order_relaxed) != 0) return false;
  failing_in.store(failing_every.load() > 0 ? failing_every.load() - 1 : -1);
  return true;
}

void* allocated(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) {
  void* memory = nullptr;
  if (!fails())
    memory = alignment <= alignof(std::max_align_t)
                 ? __real_malloc(std::max<std::size_t>(size, 1))
                 : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return allocated(size); }
void* operator new[](std::size_t size) { return allocated(size); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocated(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocated(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return fails() ? nullptr : __real_malloc(std::max<std::size_t>(size, 1));
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return fails() ? nullptr : __real_malloc(std::max<std::size_t>(size, 1));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

extern "C" void* __wrap_malloc(std::size_t size) { return fails() ? nullptr : __real_malloc(size); }

namespace wayfare::tests {
namespace {

/// What a run gave: numbers, or the text of an Error.
using Bytes = std::vector<double>;

/// Allocations fail in its life where it is meant to; nothing fails outside.
class Failures {
 public:
  Failures(long in, long every) {
    failing_every = every;
    failing_in = in;
  }
  ~Failures() { failing_in = -1; }
  Failures(const Failures&) = delete;
  Failures& operator=(const Failures&) = delete;
};

struct Scenario {
  std::string name;
  std::function<Bytes()>
      run;  ///< may throw bad_alloc; catches it itself where it goes on afterwards
};

[[noreturn]] void broken(const std::string& scenario, long in, long every,
                         const std::string& what) {
  failing_in = -1;
  std::fprintf(stderr, "%s, allocation %ld failing (then every %ld): %s\n", scenario.c_str(), in,
               every, what.c_str());
  std::exit(1);
}

Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

/// Calls f until it does not throw, as a caller would who frees memory and goes on.
template <class F>
void patiently(const F& f) {
  for (int attempt = 0; attempt < 3; ++attempt) {
    try {
      f();
      return;
    } catch (const std::bad_alloc&) {
    }
  }
}

template <class Driver>
Scenario engine(const std::string& name, int scans) {
  static const auto rooms = [] {
    std::vector<LaserScan> all;
    for (int k = 0; k < 60; ++k) all.push_back(scan_of_drive(k));
    return all;
  }();
  const bool odometry = !std::is_same_v<Driver, PedestrianDriver>;
  return {name, [=] {
            Driver driver;
            for (int k = 0; k < scans; ++k)
              patiently([&] {
                (void)driver.add(rooms[static_cast<std::size_t>(k)],
                                 odometry ? odometry_of_drive(k) : std::nullopt);
              });
            patiently([&] { (void)driver.finish(); });
            failing_in = -1;
            return numbers_of(driver);
          }};
}

std::vector<Scenario> scenarios() {
  std::vector<Scenario> all;
  for_every_decoder([&](const auto& device) {
    all.push_back({std::string("decoder ") + device.name, [device] {
                     const auto decoder = device.fresh();
                     Bytes seen;
                     const auto see = [&](const auto& message) {
                       seen.push_back(static_cast<double>(message.position()));
                     };
                     decoder->feed(device.stream, see);
                     decoder->finish(see);
                     return seen;
                   }});
  });
  for (const TextReader& reader : text_readers())
    all.push_back({"reader " + reader.name, [&reader] {
                     const ReadText read = reader.read(reader.good);
                     return bytes_of(read.error ? read.error->message : read.digest);
                   }});
  for (const auto& computation : computations<SE2d>())
    all.push_back({"graph, " + computation.name, [computation] {
                     PoseGraph2 graph = twelve<SE2d>();
                     const auto done = computation.run(graph);
                     Bytes result;
                     if (!done) return bytes_of(done.error().message);
                     for (const SE2d& x : graph.poses)
                       result.insert(result.end(), {x.x(), x.y(), x.rotation().sin()});
                     return result;
                   }});
  all.push_back(engine<GraphDriver>("graph SLAM", 40));
  all.push_back(engine<SubmapDriver>("submap SLAM", 40));
  all.push_back(engine<HectorDriver>("Hector SLAM", 20));
  all.push_back(engine<PedestrianDriver>("pedestrian SLAM", 10));
  all.push_back({"particle SLAM", [] {
                   RadarSlam slam(few_particles());
                   for (int k = 1; k < 12; ++k) {
                     patiently([&] { (void)slam.move(motion_of_drive(k)); });
                     patiently([&] { (void)slam.add_lidar(scan_of_drive(k)); });
                     patiently(
                         [&] { (void)slam.add_radar(time_of_drive(k), detections_of_drive(k)); });
                   }
                   failing_in = -1;
                   return numbers_of(slam);
                 }});
  all.push_back({"localisation", [] {
                   Localiser localiser(map_of_room(), quick_options(), 1);
                   patiently([&] { (void)localiser.start_at(start_of_drive()); });
                   for (int k = 0; k < 12; ++k) {
                     patiently(
                         [&] { (void)localiser.add_scan(scan_of_drive(k), odometry_of_drive(k)); });
                   }
                   failing_in = -1;
                   return numbers_of(localiser);
                 }});
  return all;
}

struct Counts {
  long same = 0, other = 0, thrown = 0;
};

/// One run with failures; its result is finite.
void run_failing(const Scenario& s, long in, long every, const Bytes& good, Counts& counts) {
  try {
    const Failures failures(in, every);
    const Bytes result = s.run();
    if (!all_finite(std::span<const double>(result)))
      broken(s.name, in, every, "the result is not finite");
    ++(result == good ? counts.same : counts.other);
  } catch (const std::bad_alloc&) {
    ++counts.thrown;
  }
}

void test(const Scenario& s, std::chrono::steady_clock::time_point until) {
  const Bytes good = s.run();
  allocations = 0;
  if (s.run() != good) broken(s.name, -1, 0, "two runs differ without failures");
  const long total = allocations;
  Counts counts;
  long tried = 0;
  Rng rng(1);
  const auto begin = std::chrono::steady_clock::now();
  const auto share = (until - begin);
  // All where there is time, else as many, evenly chosen.
  std::vector<long> order(static_cast<std::size_t>(total));
  for (long n = 0; n < total; ++n) order[static_cast<std::size_t>(n)] = n;
  for (std::size_t n = order.size(); n > 1; --n) std::swap(order[n - 1], order[rng.below(n)]);
  for (const long n : order) {
    if (std::chrono::steady_clock::now() - begin > share) break;
    run_failing(s, n, 0, good, counts);
    if (n % 3 == 0) run_failing(s, n / 3, 2 + n % 97, good, counts);
    if (++tried % 64 == 0 && s.run() != good)
      broken(s.name, n, 0, "a run without failures differs afterwards");
  }
  if (s.run() != good) broken(s.name, -1, 0, "a run without failures differs afterwards");
  std::printf(
      "%-28s %8ld allocations, %7ld of them failed: %ld results as without, %ld others, %ld "
      "bad_alloc\n",
      s.name.c_str(), total, tried, counts.same, counts.other, counts.thrown);
  std::fflush(stdout);
}

int soak(int argc, char** argv) {
  double minutes = 60.0;
  std::vector<std::string> named;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--minutes" && i + 1 < argc) {
      minutes = std::atof(argv[++i]);
    } else if (word == "--help" || word.starts_with("-")) {
      std::printf(
          "usage: soak_allocations [--minutes M] [NAME...]\nRuns decoders, readers and engines "
          "with failing "
          "allocations, M minutes in all (60). Names are parts of scenarios' names.\n");
      return word == "--help" ? 0 : 2;
    } else {
      named.push_back(word);
    }
  }
  std::vector<Scenario> all = scenarios();
  std::erase_if(all, [&](const Scenario& s) {
    return !named.empty() && std::none_of(named.begin(), named.end(), [&](const std::string& n) {
      return s.name.find(n) != std::string::npos;
    });
  });
  const auto end = std::chrono::steady_clock::now() +
                   std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                       std::chrono::duration<double, std::ratio<60>>(minutes));
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto now = std::chrono::steady_clock::now();
    test(all[k], now + (end - now) / static_cast<long>(all.size() - k));
  }
  return all.empty() ? 2 : 0;
}

}  // namespace
}  // namespace wayfare::tests

int main(int argc, char** argv) { return wayfare::tests::soak(argc, argv); }
