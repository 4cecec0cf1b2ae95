#include "ros/recording/wheels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace wayfare::ros {
namespace {

template <class... Numbers>
std::string text_of(const char* format, Numbers... numbers) {
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), format, numbers...);
  return text.data();
}

template <class Names>
std::string listed(const Names& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

Result<void> check_positive(const std::optional<double>& value, const char* what) {
  if (!value || (*value > 0.0 && std::isfinite(*value))) return {};
  return Error{ErrorCode::invalid, text_of("must be a positive number of metres, not %g", *value),
               what};
}

/// A name without its topic's first part would fit descriptions of several robots: the first one.
std::string description_topic(const RecordingFile& file) {
  for (const Topic& topic : file.topics())
    if (topic.type == String::kType.name && topic.name.ends_with(RobotTopics{}.description))
      return topic.name;
  return {};
}

}  // namespace

bool WheelReader::named() const {
  const WheelJoints& w = names_.wheels;
  return !w.topic.empty() || !w.names.empty() || w.radius_m || w.base_m;
}

Result<void> WheelReader::check() const {
  const WheelJoints& w = names_.wheels;
  if (auto ok = check_positive(w.radius_m, "wheel radius"); !ok) return ok;
  if (auto ok = check_positive(w.base_m, "wheel base"); !ok) return ok;
  if (const auto& speed = names_.radar_max_speed_mps; speed && !(*speed > 0.0 && *speed < 1e3))
    return Error{ErrorCode::invalid, text_of("must be a positive speed in m/s, not %g", *speed),
                 "radar's largest speed"};
  if (w.names.empty() || (w.names.size() == 2 && w.names[0] != w.names[1])) return {};
  return Error{ErrorCode::invalid, "must be two joints, of the left and the right one", "wheels"};
}

Result<void> WheelReader::listen(Lanes& lanes, io::Problems& problems) {
  if (auto ok = check(); !ok) return ok;
  const WheelJoints& w = names_.wheels;
  left_ = w.names.empty() ? RobotTopics{}.left_wheel : w.names[0];
  right_ = w.names.empty() ? RobotTopics{}.right_wheel : w.names[1];
  auto topic = choose_topic(file_, JointState::kType.name, w.topic, "joints");
  if (!topic && named()) return topic.error();
  if (!topic) {
    Error several = topic.error();
    several.message += "; none is used";
    problems.add(std::move(several));
  } else {
    topic_ = *topic;
  }
  if (topic_.empty() && named())
    return Error{ErrorCode::not_found, "has no wheels (sensor_msgs/JointState)", file_.path()};
  lanes.add<JointState>(
      topic_, readings_, [this](const JointState& m, LogTime time) { return read(m, time); },
      named() ? Need::required : Need::optional);
  const std::string described = description_topic(file_);
  if (!described.empty())
    lanes.visit<String>(described, [this](const String& m) { urdf_ = m.data; });
  return {};
}

Result<WheelReader::Reading> WheelReader::read(const JointState& m, LogTime time) {
  const auto index = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(m.name.begin(), m.name.end(), name) - m.name.begin());
  };
  const std::size_t left = index(left_), right = index(right_), none = m.name.size();
  joints_.insert(m.name.begin(), m.name.end());
  if (left == none && right == none) return Reading{time};
  if (left == none || right == none)
    return Error{ErrorCode::invalid,
                 "has '" + (left == none ? right_ : left_) + "' without '" +
                     (left == none ? left_ : right_) + "'; there is " + listed(m.name),
                 "name"};
  if (m.position.empty() && m.velocity.empty())
    return Error{ErrorCode::invalid, "has neither positions nor velocities", "position"};
  if (!by_position_) by_position_ = !m.position.empty();
  const std::vector<double>& values = *by_position_ ? m.position : m.velocity;
  const char* const field = *by_position_ ? "position" : "velocity";
  if (values.size() != none)
    return Error{
        ErrorCode::invalid,
        "has " + std::to_string(values.size()) + " values for " + std::to_string(none) + " joints",
        field};
  if (!std::isfinite(values[left]) || !std::isfinite(values[right]))
    return Error{ErrorCode::invalid, "of a wheel is not finite", field};
  return Reading{time, true, values[left], values[right]};
}

Error WheelReader::missing() const {
  const std::string& name = joints_.contains(left_) ? right_ : left_;
  return {ErrorCode::not_found, "has no wheel '" + name + "'; there is " + listed(joints_), topic_};
}

Result<RobotDescription> WheelReader::description() const {
  auto found = describe(urdf_, left_, right_);
  if (found) return found;
  Error error = found.error();
  error.source = RobotTopics{}.description;
  return error;
}

Result<void> WheelReader::finish(RobotRun& run) const {
  auto done = roll(run);
  if (done || named()) return done;
  Error error = done.error();
  error.message += "; the wheels are left out";
  run.problems.add(std::move(error));
  run.recording.wheels.clear();
  return {};
}

Result<void> WheelReader::roll(RobotRun& run) const {
  const auto described = description();
  if (!described) return described.error();
  Recording& r = run.recording;
  r.radar_max_speed_m_s =
      names_.radar_max_speed_mps.value_or(described->radar_max_speed_mps.value_or(0.0));
  const bool found = std::ranges::any_of(readings_, &Reading::found);
  if (!found && !named()) return {};
  if (!found) return missing();
  const WheelJoints& w = names_.wheels;
  const std::optional<double> radius_m = w.radius_m ? w.radius_m : described->wheel_radius_m;
  const double base_m = w.base_m ? *w.base_m : described->wheel_base_m.value_or(0.0);
  if (!radius_m)
    return Error{ErrorCode::not_found,
                 "has wheels, but their radius is neither given nor in a robot description",
                 topic_};
  if (auto ok = check_positive(radius_m, "wheel radius of the robot description"); !ok) return ok;
  if (base_m < 0.0)
    return Error{
        ErrorCode::invalid,
        "has '" + left_ + "' on the right of '" + right_ + "': left and right are exchanged",
        RobotTopics{}.description};
  const std::size_t problems = run.problems.count();
  r.wheels = distances(*radius_m, run.problems);
  if (2 * (run.problems.count() - problems) > r.wheels.size())
    return Error{
        ErrorCode::invalid,
        text_of("jumps in most of its messages: wheels of %g m radius do not turn like that",
                *radius_m),
        topic_};
  r.wheel_base_m = base_m;
  run.wheel_topic = topic_;
  return {};
}

std::vector<WheelSample> WheelReader::distances(double radius_m, io::Problems& problems) const {
  std::vector<WheelSample> wheels;
  const Reading* before = nullptr;
  double left_mps = 0.0, right_mps = 0.0;
  for (const Reading& now : readings_) {
    if (!now.found || (before != nullptr && now.time <= before->time)) continue;
    if (before == nullptr) {
      wheels.push_back({now.time});
      before = &now;
      continue;
    }
    WheelSample rolled = step(*before, now, radius_m);
    const double dt = to_seconds(now.time - before->time);
    const double most_m = std::max(std::abs(rolled.left_m), std::abs(rolled.right_m));
    if (!(most_m <= names_.wheels.max_speed_mps * dt)) {
      problems.add({ErrorCode::invalid,
                    text_of("a wheel jumps by %.3f m in %.3f s at %.3f s: bridged at the speed "
                            "before",
                            most_m, dt, now.time.seconds()),
                    topic_});
      rolled = {now.time, left_mps * dt, right_mps * dt};
    }
    left_mps = rolled.left_m / dt, right_mps = rolled.right_m / dt;
    wheels.push_back(rolled);
    before = &now;
  }
  return wheels;
}

WheelSample WheelReader::step(const Reading& before, const Reading& now, double radius_m) const {
  if (*by_position_)
    return {now.time, (now.left - before.left) * radius_m, (now.right - before.right) * radius_m};
  const double half_s = 0.5 * to_seconds(now.time - before.time);
  return {now.time, (before.left + now.left) * half_s * radius_m,
          (before.right + now.right) * half_s * radius_m};
}

namespace {

/// The angle turned by a time, interpolated linearly.
class Turned {
 public:
  void add(LogTime time, double by_rad) {
    angles_rad_.push_back(by_rad + (times_.empty() ? 0.0 : angles_rad_.back()));
    times_.push_back(time);
  }
  [[nodiscard]] double at(LogTime time) const {
    const auto next = std::ranges::lower_bound(times_, time);
    if (next == times_.end()) return angles_rad_.back();
    const auto i = static_cast<std::size_t>(next - times_.begin());
    if (i == 0) return angles_rad_.front();
    const double u = to_seconds(time - times_[i - 1]) / to_seconds(times_[i] - times_[i - 1]);
    return angles_rad_[i - 1] + u * (angles_rad_[i] - angles_rad_[i - 1]);
  }

 private:
  std::vector<LogTime> times_;
  std::vector<double> angles_rad_;
};

/// By the wheels, and by the gyro.
using Turns = std::array<Turned, 2>;

Turns turns_of(const Recording& r) {
  Turns turns;
  for (const WheelSample& w : r.wheels)
    turns[0].add(w.time, (w.right_m - w.left_m) / r.wheel_base_m);
  LogTime before = r.gyro.front().time;
  for (const GyroSample& g : r.gyro) {
    turns[1].add(g.time, g.turn_rate_rad_s * to_seconds(g.time - before));
    before = g.time;
  }
  return turns;
}

std::string judgement(double ratio, double base_m) {
  if (!std::isfinite(ratio)) return "the gyro does not turn";
  if (std::abs(ratio) < 0.05) return "the wheels hardly turn";
  if (ratio < 0.0)
    return "in the other sense: are left and right exchanged, or the unit mounted upside down?";
  return text_of("a wheel base of %.3f m instead of %.3f m would agree on average", base_m * ratio,
                 base_m);
}

}  // namespace

void compare_with_gyro(const Recording& r, const std::string& topic, io::Problems& problems) {
  if (r.wheels.empty() || r.gyro.empty() || !(r.wheel_base_m > 0.0)) return;
  constexpr double kInterval_s = 2.0;
  constexpr double kTurn_rad = 0.2;  // less is no turn
  constexpr double kBias_rad = 0.1;  // of a gyro in an interval
  constexpr double kShare = 0.3;     // of the turn, beyond slip
  constexpr std::size_t kLeast = 5;  // turns
  const Turns turns = turns_of(r);
  std::size_t all = 0, apart = 0;
  double product = 0.0, square = 0.0;
  const LogTime end = std::min(r.wheels.back().time, r.gyro.back().time);
  LogTime from = std::max(r.wheels.front().time, r.gyro.front().time);
  for (LogTime to = from + from_seconds(kInterval_s); to <= end;
       from = to, to += from_seconds(kInterval_s)) {
    const double wheels = turns[0].at(to) - turns[0].at(from);
    const double gyro = turns[1].at(to) - turns[1].at(from);
    const double turn = std::max(std::abs(wheels), std::abs(gyro));
    if (turn < kTurn_rad) continue;
    ++all;
    if (std::abs(wheels - gyro) > kBias_rad + kShare * turn) ++apart;
    product += wheels * gyro, square += gyro * gyro;
  }
  if (all < kLeast || 2 * apart <= all) return;
  const double ratio = product / square;
  problems.add({ErrorCode::invalid,
                "the wheels contradict the gyro in " + std::to_string(apart) + " of " +
                    std::to_string(all) + text_of(" turns: they turn %.2f times as far", ratio) +
                    ", " + judgement(ratio, r.wheel_base_m),
                topic});
}

}  // namespace wayfare::ros
