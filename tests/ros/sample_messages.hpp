#pragma once

// One message of each type, every field with a different value.

#include <numeric>
#include <tuple>

#include <wayfare/ros/messages.hpp>

namespace wayfare::testing {

/// Fills every field it visits with increasing numbers.
class Filler {
 public:
  template <class T>
  void operator()(const char*, T& value) {
    fill(value);
  }
  void ros1_only(const char*, std::uint32_t& value) { fill(value); }

 private:
  template <class T>
  requires std::is_arithmetic_v<T>
  void fill(T& value) { value = static_cast<T>(++count_ % 100); }
  void fill(bool& value) { value = true; }
  void fill(ros::Stamp& s) { s = {1'600'000'000 + ++count_, 123'456'789}; }
  void fill(std::string& text) { text = std::string(static_cast<std::size_t>(++count_ % 5), 'a'); }
  template <class T>
  void fill(std::vector<T>& list) {
    for (int i = 0; i < 3; ++i) fill(list.emplace_back());
  }
  template <class T, std::size_t N>
  void fill(std::array<T, N>& list) {
    for (T& item : list) fill(item);
  }
  template <class M>
  requires requires { M::kType; }
  void fill(M& message) { M::fields(message, *this); }

  int count_ = 0;
};

template <class M>
M filled() {
  M message;
  Filler filler;
  M::fields(message, filler);
  return message;
}

using AllMessages =
    std::tuple<ros::Header, ros::LaserScan, ros::PointCloud2, ros::Imu, ros::MagneticField,
               ros::NavSatFix, ros::Odometry, ros::TfMessage, ros::PoseStamped,
               ros::PoseWithCovarianceStamped, ros::Path, ros::OccupancyGrid, ros::RadarScan,
               ros::JointState, ros::String, ros::Clock, ros::PoseArray, ros::ParticleCloud>;

template <class Visit, std::size_t... I>
void for_each_message(Visit visit, std::index_sequence<I...>) {
  (visit(filled<std::tuple_element_t<I, AllMessages>>()), ...);
}
template <class Visit>
void for_each_message(Visit visit) {
  for_each_message(visit, std::make_index_sequence<std::tuple_size_v<AllMessages>>());
}

}  // namespace wayfare::testing
