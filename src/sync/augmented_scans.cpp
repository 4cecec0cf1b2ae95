#include <wayfare/sync/augmented_scans.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <utility>

namespace wayfare {
namespace {

// Cumulative sums of N increments over time, interpolated.
template <std::size_t N>
class Track {
 public:
  using Values = std::array<double, N>;

  [[nodiscard]] bool empty() const { return nodes_.empty(); }
  [[nodiscard]] LogTime last_time() const { return nodes_.back().time; }

  void add(LogTime time, const Values& increments, bool known) {
    Values total = nodes_.empty() ? Values{} : nodes_.back().total;
    if (!nodes_.empty())
      for (std::size_t i = 0; i < N; ++i) total[i] += increments[i];
    nodes_.push_back({time, total, known && !nodes_.empty()});
  }

  // Linear between samples, constant before the first and after the last.
  [[nodiscard]] Values at(LogTime time) const {
    if (nodes_.empty()) return {};
    const auto after = upper(time);
    if (after == nodes_.begin()) return nodes_.front().total;
    if (after == nodes_.end()) return nodes_.back().total;
    const Node &a = *(after - 1), &b = *after;
    const double u = to_seconds(time - a.time) / to_seconds(b.time - a.time);
    Values values;
    for (std::size_t i = 0; i < N; ++i) values[i] = a.total[i] + u * (b.total[i] - a.total[i]);
    return values;
  }

  // Whether samples cover all of [from, to].
  [[nodiscard]] bool known(LogTime from, LogTime to) const {
    if (nodes_.empty() || from < nodes_.front().time || to > nodes_.back().time) return false;
    for (auto node = upper(from); node != nodes_.end(); ++node) {
      if (!node->known) return false;
      if (node->time >= to) break;
    }
    return true;
  }

  // The first sample's time after `time`.
  [[nodiscard]] std::optional<LogTime> after(LogTime time) const {
    const auto node = upper(time);
    return node == nodes_.end() ? std::nullopt : std::optional(node->time);
  }

  void drop_before(LogTime time) {
    while (nodes_.size() > 2 && nodes_[1].time <= time) nodes_.pop_front();
  }

 private:
  struct Node {
    LogTime time;
    Values total;
    bool known;  // of the interval that ends here
  };
  [[nodiscard]] auto upper(LogTime time) const {
    return std::partition_point(nodes_.begin(), nodes_.end(),
                                [&](const Node& n) { return n.time <= time; });
  }

  std::deque<Node> nodes_;
};

enum Stream : std::size_t { kWheels, kGyro, kRadar, kLaser, kStreams };

}  // namespace

class RobotSynchroniser::Impl {
 public:
  explicit Impl(const SyncParams& params) : params_(params) {
    WAYFARE_EXPECTS(params.period > Duration::zero() && params.scans > 0,
                    "period and number of scans must be positive");
  }

  bool push(const WheelSample& sample) {
    const bool finite = std::isfinite(sample.left_m) && std::isfinite(sample.right_m);
    if (!finite) return refuse_not_finite(wheels_, kWheels, sample.time);
    if (!take_time(kWheels, sample.time)) return false;
    wheels_.add(sample.time, {sample.left_m, sample.right_m}, near_last(wheels_, sample.time));
    return true;
  }

  bool push(const GyroSample& sample) {
    if (!std::isfinite(sample.turn_rate_rad_s)) return refuse_not_finite(gyro_, kGyro, sample.time);
    if (!take_time(kGyro, sample.time)) return false;
    const double dt_s = gyro_.empty() ? 0.0 : to_seconds(sample.time - gyro_.last_time());
    gyro_.add(sample.time, {sample.turn_rate_rad_s * dt_s}, near_last(gyro_, sample.time));
    return true;
  }

  bool push(const RadarScan& scan) {
    if (!take_time(kRadar, scan.time)) return false;
    radar_.push_back(scan);
    return true;
  }

  bool push(const LaserScan& scan) {
    if (!take_time(kLaser, scan.time)) return false;
    lasers_.push_back(scan);
    return true;
  }

  void finish() { finished_ = true; }

  std::optional<SyncedStep> next() {
    if (!started_ && !start()) return std::nullopt;
    while (true) {
      const LogTime time = next_time();
      if (!ready(time)) return std::nullopt;
      if (radar_.empty() || radar_.front().time != time) return step_to(time);
      const std::size_t count = group_size();
      if (count == 0) return std::nullopt;
      if (count >= params_.min_scans) return step_with_radar(time, count);
      radar_.erase(radar_.begin(), radar_.begin() + static_cast<std::ptrdiff_t>(count));
      statistics_.dropped_scans += count;
    }
  }

  [[nodiscard]] const SyncStatistics& statistics() const { return statistics_; }

 private:
  bool take_time(Stream stream, LogTime time) {
    constexpr LogTime kLast = LogTime::from_nanoseconds(Duration::max().count());
    // After such a time no step could follow.
    if (time > kLast - params_.period - params_.max_wait) {
      ++statistics_.refused_late;
      return false;
    }
    if ((latest_[stream] && time <= *latest_[stream]) || (started_ && time < last_)) {
      ++statistics_.refused_late;
      return false;
    }
    if (!latest_[stream]) first_ = first_ ? std::min(*first_, time) : time;
    latest_[stream] = time;
    now_ = now_ ? std::max(*now_, time) : time;
    return true;
  }

  template <std::size_t N>
  [[nodiscard]] bool near_last(const Track<N>& track, LogTime time) const {
    return !track.empty() && time - track.last_time() <= params_.largest_gap;
  }

  // The motion over the sample's interval is unknown; the next sample starts at its time.
  template <std::size_t N>
  bool refuse_not_finite(Track<N>& track, Stream stream, LogTime time) {
    if (!take_time(stream, time)) return false;
    track.add(time, {}, false);
    ++statistics_.refused_not_finite;
    return false;
  }

  // Whether the stream has reached `time`, or has timed out.
  [[nodiscard]] bool has_reached(Stream stream, LogTime time) const {
    return finished_ || (latest_[stream] && *latest_[stream] >= time) ||
           *now_ >= time + params_.max_wait;
  }
  [[nodiscard]] bool ready(LogTime time) const {
    if (time > *now_) return false;
    for (std::size_t s = 0; s < kStreams; ++s)
      if (!has_reached(static_cast<Stream>(s), time)) return false;
    return true;
  }

  bool start() {
    if (!first_ || !ready(*first_)) return false;
    grid_ = last_ = *first_;
    started_ = true;
    return true;
  }

  [[nodiscard]] LogTime next_time() const {
    LogTime time = grid_;
    if (const auto next = next_measurement(); next && *next - last_ > params_.longest_silence)
      time = std::max(time, *next);
    if (!lasers_.empty()) time = std::min(time, lasers_.front().time);
    if (!radar_.empty()) time = std::min(time, radar_.front().time);
    return time;
  }

  // The earliest time after the last step at which any stream measured.
  [[nodiscard]] std::optional<LogTime> next_measurement() const {
    std::optional<LogTime> next = wheels_.after(last_);
    const auto consider = [&](std::optional<LogTime> time) {
      if (time && (!next || *time < *next)) next = time;
    };
    consider(gyro_.after(last_));
    if (!radar_.empty()) consider(radar_.front().time);
    if (!lasers_.empty()) consider(lasers_.front().time);
    return next;
  }

  // Number of radar frames in the next augmented scan; 0 while it is incomplete.
  [[nodiscard]] std::size_t group_size() const {
    std::size_t count = 1;
    while (count < std::min(params_.scans, radar_.size()) &&
           radar_[count].time - radar_[count - 1].time <= params_.max_wait)
      ++count;
    const LogTime until = radar_[count - 1].time;
    const bool whole = count == params_.scans || count < radar_.size();
    const bool silent = finished_ || *now_ > until + params_.max_wait;
    return (whole || silent) && has_reached(kWheels, until) ? count : 0;
  }

  SyncedStep step_with_radar(LogTime time, std::size_t count) {
    SyncedStep step = step_to(time);
    step.radar = gather(count);
    radar_.erase(radar_.begin(), radar_.begin() + static_cast<std::ptrdiff_t>(count));
    return step;
  }

  SyncedStep step_to(LogTime time) {
    SyncedStep step{.time = time, .since = time - last_, .wheels = {}, .gyro = {}};
    const auto wheels = wheels_.at(time);
    const auto gyro = gyro_.at(time);
    // Relative to the delivered sums, not to what is now known at that time: no count is lost.
    step.wheels = {time, wheels[0] - delivered_wheels_[0], wheels[1] - delivered_wheels_[1]};
    const double since_s = to_seconds(step.since);
    step.gyro = {time, since_s > 0.0 ? (gyro[0] - delivered_gyro_[0]) / since_s : 0.0};
    step.wheels_known = wheels_.known(last_, time);
    step.gyro_known = gyro_.known(last_, time);
    if (!step.gyro_known) step.gyro.turn_rate_rad_s = 0.0;
    delivered_wheels_ = wheels;
    delivered_gyro_ = gyro;
    if (!lasers_.empty() && lasers_.front().time == time) {
      step.laser = std::move(lasers_.front());
      lasers_.pop_front();
    }
    wheels_.drop_before(time);
    gyro_.drop_before(time);
    last_ = time;
    grid_ = next_on_grid(grid_, params_.period, time);
    return step;
  }

  [[nodiscard]] AugmentedScan gather(std::size_t count) const {
    AugmentedScan scan{radar_.front().time, radar_[count - 1].time, count, {}};
    SE2d T_first_now;
    auto rolled = wheels_.at(scan.time);
    for (std::size_t i = 0; i < count; ++i) {
      const auto now = wheels_.at(radar_[i].time);
      T_first_now = T_first_now.plus(twist(now[0] - rolled[0], now[1] - rolled[1]));
      rolled = now;
      add_points(radar_[i], T_first_now * params_.T_base_radar.raw(), velocity(i, count),
                 scan.points);
    }
    return scan;
  }

  // Velocity of the radar in its own axes, over the adjacent frames; nullopt without wheels.
  [[nodiscard]] std::optional<Eigen::Vector2d> velocity(std::size_t i, std::size_t count) const {
    const LogTime from = radar_[i > 0 ? i - 1 : 0].time,
                  to = radar_[std::min(i + 1, count - 1)].time;
    if (to == from || !wheels_.known(from, to)) return std::nullopt;
    const auto a = wheels_.at(from), b = wheels_.at(to);
    const Eigen::Vector3d base = twist(b[0] - a[0], b[1] - a[1]) / to_seconds(to - from);
    const SE2d& T_base_radar = params_.T_base_radar.raw();
    const Eigen::Vector2d& arm = T_base_radar.translation();
    const Eigen::Vector2d at_radar(base.x() - base.z() * arm.y(), base.y() + base.z() * arm.x());
    return Eigen::Vector2d(T_base_radar.rotation().inverse() * at_radar);
  }

  [[nodiscard]] Eigen::Vector3d twist(double left_m, double right_m) const {
    const double heading_change =
        params_.wheel_base_m > 0.0 ? (right_m - left_m) / params_.wheel_base_m : 0.0;
    return {0.5 * (left_m + right_m), 0.0, heading_change};
  }

  void add_points(const RadarScan& scan, const SE2d& T_first_radar,
                  const std::optional<Eigen::Vector2d>& velocity_m_s, PointSet& to) const {
    for (const RadarPoint& measured : scan.points) {
      if (velocity_m_s && params_.moving_m_s > 0.0 &&
          is_moving(measured, *velocity_m_s, params_.array, params_.moving_m_s))
        continue;
      const RadarPoint p =
          velocity_m_s ? compensate_bearing(measured, *velocity_m_s, params_.array) : measured;
      const Eigen::Vector2d at(p.x_m, p.y_m);
      const double range = at.norm();
      // False for NaN.
      if (!(range >= params_.min_range_m && range <= params_.max_range_m)) continue;
      if (p.snr_db < params_.min_snr_db) continue;
      to.push_back((T_first_radar * at).cast<float>());
    }
  }

  SyncParams params_;
  Track<2> wheels_;
  Track<1> gyro_;
  std::deque<RadarScan> radar_;
  std::deque<LaserScan> lasers_;
  std::array<std::optional<LogTime>, kStreams>
      latest_{};                        // time of each stream's latest measurement
  std::optional<LogTime> now_, first_;  // latest and earliest time of all streams
  LogTime grid_, last_;                 // next time of the time base; time of the last step
  Track<2>::Values delivered_wheels_{};
  Track<1>::Values delivered_gyro_{};
  bool started_ = false, finished_ = false;
  SyncStatistics statistics_;
};

RobotSynchroniser::RobotSynchroniser(const SyncParams& params)
    : impl_(detail::make_owned<Impl>(params)) {}

bool RobotSynchroniser::push(const WheelSample& sample) { return impl_->push(sample); }
bool RobotSynchroniser::push(const GyroSample& sample) { return impl_->push(sample); }
bool RobotSynchroniser::push(const RadarScan& scan) { return impl_->push(scan); }
bool RobotSynchroniser::push(const LaserScan& scan) { return impl_->push(scan); }
void RobotSynchroniser::finish() { impl_->finish(); }
std::optional<SyncedStep> RobotSynchroniser::next() { return impl_->next(); }
const SyncStatistics& RobotSynchroniser::statistics() const { return impl_->statistics(); }

SyncParams sync_params(const Recording& recording, SyncParams params) {
  params.wheel_base_m = recording.wheel_base_m;
  params.T_base_radar = recording.T_base_radar;
  params.array.max_speed_m_s = recording.radar_max_speed_m_s;
  return params;
}

std::vector<SyncedStep> synchronise(const Recording& recording, const SyncParams& params,
                                    SyncStatistics* statistics) {
  RobotSynchroniser synchroniser(params);
  for (const WheelSample& sample : recording.wheels) synchroniser.push(sample);
  for (const GyroSample& sample : recording.gyro) synchroniser.push(sample);
  for (const RadarScan& scan : recording.radar) synchroniser.push(scan);
  for (const LaserScan& scan : recording.scans) synchroniser.push(scan);
  synchroniser.finish();
  std::vector<SyncedStep> steps;
  while (std::optional<SyncedStep> step = synchroniser.next()) steps.push_back(std::move(*step));
  if (statistics != nullptr) *statistics = synchroniser.statistics();
  return steps;
}

}  // namespace wayfare
