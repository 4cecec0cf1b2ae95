#include "recording_view.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/logger/messages.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "support/slam_outputs.hpp"

namespace wayfare::examples {
namespace {

using nlohmann::json;

/// Six columns over time for a plot. Minima and maxima of groups of samples, so that no peak is
/// lost.
class MinMaxRows {
 public:
  explicit MinMaxRows(std::uint64_t group) : group_(group) {}

  void add(double t, const std::array<double, 6>& values) {
    if (count_ == 0) begin_ = t, low_ = high_ = values;
    for (std::size_t k = 0; k < values.size(); ++k) {
      low_[k] = std::fmin(low_[k], values[k]);
      high_[k] = std::fmax(high_[k], values[k]);
    }
    end_ = t;
    if (++count_ == group_) close();
  }
  [[nodiscard]] json finished() {
    close();
    return {{"t", t_}, {"columns", columns_}, {"stride", group_}};
  }

 private:
  void close() {
    if (count_ > 0) put(begin_, low_);
    if (count_ > 1) put(end_, high_);
    count_ = 0;
  }
  void put(double t, const std::array<double, 6>& values) {
    t_.push_back(t);
    for (std::size_t k = 0; k < values.size(); ++k) columns_[k].push_back(values[k]);
  }

  std::uint64_t group_, count_ = 0;
  double begin_ = 0.0, end_ = 0.0;
  std::array<double, 6> low_{}, high_{};
  std::vector<double> t_;
  std::array<std::vector<double>, 6> columns_;
};

}  // namespace

std::string schema_of(const io::McapContents& contents, const io::McapChannel& channel) {
  for (const io::McapSchema& s : contents.schemas)
    if (s.id == channel.schema) return s.name;
  return {};
}

const io::McapChannel* find_topic(const io::McapContents& contents, const std::string& topic) {
  for (const io::McapChannel& c : contents.channels)
    if (c.topic == topic) return &c;
  return nullptr;
}

Error no_topic(const std::string& topic) {
  return Error{ErrorCode::not_found, "there is no topic '" + topic + "'"};
}

Result<RecordingView::Reader> RecordingView::reader() const {
  using std::chrono::steady_clock;
  const std::lock_guard lock(mutex_);
  std::error_code code;
  const std::uint64_t size = std::filesystem::file_size(path_, code);
  const auto now = steady_clock::now();
  if (reader_ && (size == size_ || now < reopen_)) return reader_;
  auto opened = io::McapReader::open(path_);
  if (!opened) return opened.error();
  reader_ = std::make_shared<const io::McapReader>(std::move(*opened));
  size_ = size;
  // A growing file is reread completely, which must not slow down the recording.
  const auto took = steady_clock::now() - now;
  reopen_ = now + std::max<steady_clock::duration>(std::chrono::seconds(2), 20 * took);
  return reader_;
}

Result<std::string> RecordingView::contents() const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  json out = {{"path", path_},
              {"bytes", c.bytes},
              {"messages", c.statistics.messages},
              {"chunks", c.statistics.chunks},
              {"indexed", c.indexed},
              {"start_s", c.statistics.first.seconds()},
              {"seconds", to_seconds(c.statistics.last - c.statistics.first)},
              {"topics", json::array()},
              {"problems", json::array()}};
  for (const io::McapChannel& channel : c.channels) {
    const auto count = c.statistics.messages_of.find(channel.id);
    const std::string schema = schema_of(c, channel);
    out["topics"].push_back(
        {{"topic", channel.topic},
         {"schema", schema.empty() ? channel.message_encoding : schema},
         {"messages", count == c.statistics.messages_of.end() ? 0 : count->second}});
  }
  for (const Error& problem : c.problems.first())
    if (out["problems"].size() < 20) out["problems"].push_back(problem.to_string());
  return out.dump(-1, ' ', true, json::error_handler_t::replace);
}

Result<std::string> RecordingView::inertial(const std::string& topic, std::size_t most) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr || schema_of(c, *channel) != logger::imu_schema().name)
    return no_topic(topic);
  const auto count = c.statistics.messages_of.find(channel->id);
  const std::uint64_t n = count == c.statistics.messages_of.end() ? 0 : count->second;
  MinMaxRows rows(n <= most ? 1 : 1 + 2 * (n - 1) / std::max<std::size_t>(most, 2));
  (*file)->read({io::McapOrder::file, {topic}}, [&](const io::McapMessage& m) {
    if (const auto sample = logger::parse_imu(m.data)) {
      const Eigen::Vector3d &f = sample->specific_force_mps2, &w = sample->angular_rate_radps;
      rows.add(to_seconds(sample->time - c.statistics.first),
               {f.x(), f.y(), f.z(), w.x(), w.y(), w.z()});
    }
    return true;
  });
  return rows.finished().dump();
}

Result<std::string> RecordingView::message(const std::string& topic, double t_s) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr || channel->message_encoding != "json") return no_topic(topic);
  const LogTime until = c.statistics.first + from_seconds(t_s);
  // The last one before `until`, searched in growing intervals.
  for (double back_s = 1.0; back_s < 1e6; back_s *= 16.0) {
    std::string found;
    (*file)->read({io::McapOrder::log_time, {topic}, until - from_seconds(back_s), until},
                  [&](const io::McapMessage& m) {
                    found = m.data;
                    return true;
                  });
    if (!found.empty()) return found;
    if (until - from_seconds(back_s) < c.statistics.first) break;
  }
  return std::string("null");
}

Result<std::string> RecordingView::walk(const std::string& topic) const {
  const auto logged = logger::read_marg_recording(path_, topic);
  if (!logged) return logged.error();
  Pedestrian pedestrian{PedestrianParameters{}};
  std::array<std::vector<double>, 4> columns;
  for (const MargSample& sample : logged->samples)
    pedestrian.add(sample, [&](const PedestrianPose& p) {
      columns[0].push_back(to_seconds(p.time - logged->samples.front().time));
      columns[1].push_back(p.position_m.x());
      columns[2].push_back(p.position_m.y());
      columns[3].push_back(p.heading.degrees());
    });
  return json({{"columns", columns}}).dump();
}

Result<std::string> RecordingView::map_png(double most_s) const {
  auto robot = logger::read_robot_recording(path_);
  if (!robot) return robot.error();
  std::vector<LaserScan>& scans = robot->recording.scans;
  if (scans.empty()) return Error{ErrorCode::not_found, "there are no laser scans"};
  const LogTime end = scans.front().time + from_seconds(most_s);
  while (scans.back().time > end) scans.pop_back();
  const auto slam = run_graph_slam(robot->recording);
  if (!slam) return slam.error();
  return io::encode_png(map_picture(slam->map, slam->trajectory));
}

double RecordingView::map_cell_m() { return OccupancyGridOptions{}.resolution_m; }

}  // namespace wayfare::examples
