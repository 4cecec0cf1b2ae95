// Decoders, readers and engines with allocations that fail: soak_allocations [--minutes M]
// [NAME...].
//
// Each scenario is run with the n-th allocation failing, for n from the first to the last it makes,
// then with every n-th failing. Each run ends in the same result, an Error or std::bad_alloc; an
// engine that threw is used further and stays finite; and the same scenario without failures gives
// the same bytes afterwards.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <new>
#include <string>
#include <vector>

#include <wayfare/io/bag.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/nav/corridor_ins.hpp>

#include "abuse/decode_streams.hpp"
#include "abuse/graph_cases.hpp"
#include "abuse/io_readers.hpp"
#include "abuse/slam_localisation_support.hpp"
#include "abuse/slam_radar_support.hpp"
#include "abuse/slam_support.hpp"
#include "failing_allocations.hpp"
#include "io/mcap_samples.hpp"
#include "nav/gnss_ins_support.hpp"

namespace wayfare::tests {
namespace {

/// What a run gave: numbers, or the text of an Error.
using Bytes = std::vector<double>;

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

/// Ranges to satellites and inertial readings of a drive of seconds, smoothed.
Scenario gnss_ins() {
  const Drive drive{.rest_s = 0.5};
  const Simulated simulated = simulate(drive, 3.0, 0.02);
  const auto epochs = simulate_ranges(drive, simulated, 0.5, {}, 7);
  return {"GNSS/INS", [=] {
            GnssInsOptions options;
            options.smoothing_lag_s = 1.0;
            GnssIns ins(options);
            patiently([&] { ins.start({simulated.truth.front(), 1.0, 0.1, 0.01, 0.05}); });
            auto next = epochs.begin();
            for (const ImuSample& sample : simulated.imu) {
              patiently([&] { (void)ins.add(sample); });
              // Half a second late: replayed.
              if (next == epochs.end() || sample.time < next->time + std::chrono::milliseconds(500))
                continue;
              patiently([&] { (void)ins.add(*next); });
              ++next;
            }
            failing_in = -1;
            if (!ins.started()) return Bytes{};
            const GnssInsEstimate e = ins.estimate();
            const Eigen::Vector3d q = e.nav.q_nb.log();
            return Bytes{e.nav.position.latitude.radians(), e.nav.position.height_m, q.z(),
                         e.covariance.trace()};
          }};
}

Scenario corridor_ins() {
  return {"corridor INS", [] {
            CorridorIns ins;
            for (int k = 0; k < 20; ++k) {
              const double dt_s = to_seconds(time_of_drive(k + 1) - time_of_drive(k));
              const SE2d step = pose_of_drive(k).inverse() * pose_of_drive(k + 1);
              patiently([&] {
                (void)ins.add_motion(
                    {time_of_drive(k), step.rotation().angle().radians() / dt_s, step.x() / dt_s});
              });
              patiently([&] { (void)ins.add_scan(scan_of_drive(k)); });
            }
            failing_in = -1;
            const SE2d pose = ins.pose();
            return Bytes{pose.x(), pose.y(), pose.rotation().sin(), ins.covariance().trace()};
          }};
}

constexpr int kMessages = 12;

/// Two topics in chunks of some messages.
std::string small_mcap() {
  const auto bytes = std::make_shared<std::string>();
  auto writer =
      io::McapWriter::create(std::make_unique<testing::MemorySink>(bytes), {.chunk_bytes = 256});
  const std::uint16_t channels[] = {*writer->add_channel("/a", "bytes", 0),
                                    *writer->add_channel("/b", "bytes", 0)};
  for (int k = 0; k < kMessages; ++k)
    (void)writer->write(channels[k % 2], LogTime::from_seconds(kMessages - k), LogTime(),
                        std::string(60, 'm'));
  (void)writer->close();
  return *bytes;
}

std::string small_bag() {
  io::BagWriter writer(256);
  const std::uint32_t connections[] = {
      writer.add_connection({.topic = "/a", .type = "t/A", .md5 = std::string(32, '0')}),
      writer.add_connection({.topic = "/b", .type = "t/B", .md5 = std::string(32, '1')})};
  for (int k = 0; k < kMessages; ++k)
    (void)writer.write(connections[k % 2], LogTime::from_seconds(k + 1), std::string(60, 'b'));
  return writer.finish();
}

void append(Bytes& seen, const std::string& topic, std::string_view data, LogTime time) {
  seen.push_back(static_cast<double>(std::hash<std::string_view>()(topic) % 1000));
  seen.push_back(static_cast<double>(data.size()));
  seen.push_back(time.seconds());
}

/// Opened and read, whole and without the index at the end.
std::vector<Scenario> recordings() {
  const std::string mcap = small_mcap(), bag = small_bag();
  std::vector<Scenario> all;
  for (const bool whole : {true, false}) {
    const std::string how = whole ? ", indexed" : ", cut";
    all.push_back({"MCAP" + how, [bytes = mcap.substr(0, whole ? mcap.size() : mcap.size() / 2)] {
                     Bytes seen;
                     const auto reader = io::McapReader::parse(bytes, "memory");
                     if (!reader) return bytes_of(reader.error().message);
                     (void)reader->read({io::McapOrder::log_time}, [&](const io::McapMessage& m) {
                       append(seen, m.channel->topic, m.data, m.log_time);
                       return true;
                     });
                     return seen;
                   }});
    all.push_back({"bag" + how, [bytes = bag.substr(0, whole ? bag.size() : bag.size() * 2 / 3)] {
                     Bytes seen;
                     const auto reader = io::BagReader::parse(bytes, "memory");
                     if (!reader) return bytes_of(reader.error().message);
                     (void)reader->read([&](const io::BagMessage& m) {
                       append(seen, m.connection->topic, m.data, m.time);
                       return true;
                     });
                     return seen;
                   }});
  }
  all.push_back({"MCAP writer", [] { return bytes_of(small_mcap()); }});
  all.push_back({"bag writer", [] { return bytes_of(small_bag()); }});
  return all;
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
  all.push_back(gnss_ins());
  all.push_back(corridor_ins());
  for (Scenario& s : recordings()) all.push_back(std::move(s));
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

/// The number of allocations that failed first in a run.
long test(const Scenario& s, std::chrono::steady_clock::time_point until) {
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
  return tried;
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
  long tried = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto now = std::chrono::steady_clock::now();
    tried += test(all[k], now + (end - now) / static_cast<long>(all.size() - k));
  }
  std::printf("%zu scenarios, %ld failing allocations, none broke anything\n", all.size(), tried);
  return all.empty() ? 2 : 0;
}

}  // namespace
}  // namespace wayfare::tests

int main(int argc, char** argv) { return wayfare::tests::soak(argc, argv); }
