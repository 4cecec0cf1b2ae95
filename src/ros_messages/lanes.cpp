#include "lanes.hpp"

namespace wayfare::ros {

Result<std::string> choose_topic(const RecordingFile& file, std::string_view type,
                                 const std::string& named, const char* what) {
  std::vector<std::string> fitting;
  std::string list;
  for (const Topic& topic : file.topics())
    if (topic.type == type) {
      fitting.push_back(topic.name);
      list += (list.empty() ? "" : ", ") + topic.name;
    }
  const std::string of_type = " of " + std::string(type);
  if (named.empty() && fitting.size() > 1)
    return Error{ErrorCode::invalid,
                 "holds several topics" + of_type + ": name the " + what + " among " + list,
                 file.path()};
  if (named.empty()) return fitting.empty() ? std::string() : fitting.front();
  if (std::find(fitting.begin(), fitting.end(), named) != fitting.end()) return named;
  return Error{ErrorCode::not_found,
               "holds no topic " + named + of_type + (fitting.empty() ? "" : "; there is " + list),
               file.path()};
}

Result<void> Lanes::run(io::Problems& problems) {
  std::set<std::string> topics;
  for (const auto& [topic, lane] : lanes_) topics.insert(topic);
  const io::Problems met = file_.read(topics, [&](const RecordedMessage& raw) {
    Lane& lane = lanes_[raw.topic.name];
    ++lane.messages;
    if (auto taken = lane.take(raw, lane); !taken) {
      Error fault = taken.error();
      fault.message = fault.source + (fault.source.empty() ? "" : " ") + fault.message;
      fault.source = raw.topic.name, fault.line = lane.messages;
      if (!lane.first_fault) lane.first_fault = fault;
      problems.add(std::move(fault));
    }
    return true;
  });
  for (const Error& error : met.first()) problems.add(error);
  for (const auto& sort : sort_) sort();
  for (const auto& [topic, lane] : lanes_)
    if (lane.stamped && lane.late.empty() && lane.first_fault) {
      Error fault = *lane.first_fault;
      fault.message += " (and so it is with all " + std::to_string(lane.messages) + " messages)";
      return fault;
    }
  return check_clocks();
}

Result<void> Lanes::check_clocks() {
  const std::string* first = nullptr;
  Duration reference{0};
  for (auto& [topic, lane] : lanes_) {
    if (lane.late.empty()) continue;
    const auto middle = lane.late.begin() + static_cast<long>(lane.late.size() / 2);
    std::nth_element(lane.late.begin(), middle, lane.late.end());
    if (first == nullptr) {
      first = &topic;
      reference = *middle;
    } else if (const Duration apart = *middle - reference;
               apart > names_.clock_tolerance || apart < -names_.clock_tolerance) {
      return Error{ErrorCode::invalid,
                   "is stamped " + std::to_string(to_seconds(apart)) + " s from " + *first +
                       ", counted from when both were received: their clocks differ; take the "
                       "times of receipt instead",
                   topic};
    }
  }
  return {};
}

}  // namespace wayfare::ros
