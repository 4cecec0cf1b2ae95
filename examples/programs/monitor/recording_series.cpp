#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/io/mcap.hpp>

#include "message_text.hpp"
#include "recording_query.hpp"
#include "recording_view.hpp"

namespace wayfare::examples {
namespace {

using nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Columns over time for a plot. Minima and maxima of groups of messages, so that no peak is lost.
class MinMaxRows {
 public:
  MinMaxRows(std::size_t columns, std::uint64_t group, double gap_s)
      : group_(group), gap_s_(gap_s), columns_(columns) {}

  void add(double t, const std::vector<double>& values) {
    if (t - end_ > gap_s_) {
      close();
      put(0.5 * (end_ + t), std::vector<double>(values.size(), kNone));
    }
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
  void put(double t, const std::vector<double>& values) {
    t_.push_back(t);
    for (std::size_t k = 0; k < values.size(); ++k) columns_[k].push_back(values[k]);
  }

  std::uint64_t group_, count_ = 0;
  double gap_s_, begin_ = 0.0, end_ = std::numeric_limits<double>::infinity();
  std::vector<double> low_, high_;
  std::vector<double> t_;
  std::vector<std::vector<double>> columns_;
};

/// Counts of intervals in steps of a quarter of an octave.
class Intervals {
 public:
  void add(Duration interval) {
    const auto ns = static_cast<double>(std::max<Duration::rep>(interval.count(), 1));
    ++counts_[static_cast<std::size_t>(kSteps * std::log2(ns))];
    ++all_;
  }
  /// What 95 % do not exceed: messages may come in groups.
  [[nodiscard]] double usual_s() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i)
      if (20 * (sum += counts_[i]) >= 19 * all_ && all_ > 0)
        return 1e-9 * std::exp2(static_cast<double>(i + 1) / kSteps);
    return std::numeric_limits<double>::infinity();
  }

 private:
  static constexpr double kSteps = 4.0;
  std::array<std::uint64_t, 256> counts_{};  // up to 2^63 ns
  std::uint64_t all_ = 0;
};

/// The names and indices that lead to a field.
using FieldPath = std::vector<std::string>;

FieldPath path_of(const std::string& field) {
  FieldPath path(1);
  for (const char c : field) {
    if (c == '.') {
      path.emplace_back();
    } else {
      path.back() += c;
    }
  }
  return path;
}

/// NaN if there is no such number.
double number_at(const json& message, const FieldPath& path) {
  const json* at = &message;
  for (const std::string& name : path) {
    std::size_t index = 0;
    if (at->is_object() && at->contains(name)) {
      at = &(*at)[name];
    } else if (at->is_array() &&
               std::from_chars(name.data(), name.data() + name.size(), index).ec == std::errc{} &&
               index < at->size()) {
      at = &(*at)[index];
    } else {
      return kNone;
    }
  }
  if (at->is_boolean()) return at->get<bool>() ? 1.0 : 0.0;
  return at->is_number() ? at->get<double>() : kNone;
}

}  // namespace

double RecordingView::gap_s(const io::McapReader& file, const io::McapChannel& channel) const {
  const auto& counts = file.contents().statistics.messages_of;
  const auto count = counts.find(channel.id);
  const std::uint64_t n = count == counts.end() ? 0 : count->second;
  {
    const std::lock_guard lock(mutex_);
    const auto known = gaps_.find(channel.topic);
    if (known != gaps_.end() && known->second.messages == n) return known->second.s;
  }
  Intervals intervals;
  std::optional<LogTime> before;
  file.read({io::McapOrder::file, {channel.topic}}, [&](const io::McapMessage& m) {
    const LogTime now = measured_at(m);
    if (before) intervals.add(now - *before);
    before = now;
    return true;
  });
  const double s = 5.0 * intervals.usual_s();
  const std::lock_guard lock(mutex_);
  gaps_[channel.topic] = {n, s};
  return s;
}

Result<std::string> RecordingView::series(const std::string& topic,
                                          const std::vector<std::string>& fields,
                                          const Interval& interval, std::size_t most) const {
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  const io::McapChannel* channel = find_topic(c, topic);
  if (channel == nullptr || channel->message_encoding != "json") return no_topic(topic);
  const io::McapQuery query = query_of(c, {topic}, interval);
  std::uint64_t n = 0;
  (*file)->read(query, [&](const io::McapMessage&) { return ++n, true; });
  std::vector<FieldPath> paths;
  for (const std::string& field : fields) paths.push_back(path_of(field));
  MinMaxRows rows(paths.size(), n <= most ? 1 : 1 + 2 * (n - 1) / std::max<std::size_t>(most, 2),
                  gap_s(**file, *channel));
  std::vector<double> values(paths.size());
  (*file)->read(query, [&](const io::McapMessage& m) {
    const json message = json::parse(m.data, nullptr, false);
    std::ranges::transform(paths, values.begin(),
                           [&](const FieldPath& path) { return number_at(message, path); });
    rows.add(to_seconds(measured_at(m) - c.statistics.first), values);
    return true;
  });
  return rows.finished().dump();
}

Result<std::string> RecordingView::range(const std::set<std::string>& topics,
                                         const Interval& interval, bool before) const {
  constexpr std::size_t kMost = std::size_t{4} << 20;
  const auto file = reader();
  if (!file) return file.error();
  const io::McapContents& c = (*file)->contents();
  io::McapQuery query = query_of(c, topics, interval);
  query.order = io::McapOrder::log_time;
  std::string out;
  const auto add = [&](const io::McapMessage& m) { out += message_lines(m, ""); };
  if (before)
    for (const std::string& topic : topics)
      if (find_topic(c, topic) != nullptr) read_last(**file, topic, query.from - Duration(1), add);
  LogTime until = query.until;
  if (!topics.empty())
    (*file)->read(query, [&](const io::McapMessage& m) {
      if (out.size() > kMost && m.log_time > query.from) {
        until = m.log_time - Duration(1);
        return false;
      }
      add(m);
      return true;
    });
  return out + json({{"until", to_seconds(until - c.statistics.first)}}).dump() + '\n';
}

}  // namespace wayfare::examples
