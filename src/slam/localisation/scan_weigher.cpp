#include "slam/localisation/scan_weigher.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <wayfare/core/parallel.hpp>

#include "map/kernels/kernels.hpp"

namespace wayfare {
namespace {

constexpr std::size_t kBlock = 1024;  // particles per task

std::size_t at_least_one(int n) { return static_cast<std::size_t>(std::max(n, 1)); }

}  // namespace

ScanWeigher::ScanWeigher(const LaserScan& scan, const LocalisationOptions& options)
    : options_(options) {
  pick_ends(scan);
  if (options.model == ScanLikelihood::beam) pick_beams(scan);
  enough_ = ends_ >= at_least_one(options.min_beams);
}

ScanWeigher::ScanWeigher(const PointSet& points, const LocalisationOptions& options)
    : options_(options), sensor_(RangeSensor::radar) {
  ends_ = std::min(points.size(), at_least_one(options.radar.points));
  for (std::size_t k = 0; k < ends_; ++k) add_end(points[k * points.size() / ends_]);
  pad_ends();
  enough_ = ends_ >= at_least_one(options.radar.min_points);
}

void ScanWeigher::pick_ends(const LaserScan& scan) {
  const SE2d& T_base_laser = options_.T_base_laser.raw();
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i)
    if (scan.returned(i) && static_cast<double>(scan.ranges_m[i]) < options_.max_range_m)
      usable.push_back(i);
  ends_ = std::min(usable.size(), at_least_one(options_.beams));
  for (std::size_t k = 0; k < ends_; ++k) {
    const std::size_t i = usable[k * usable.size() / ends_];
    const double bearing = scan.bearing(i).radians();
    const auto range = static_cast<double>(scan.ranges_m[i]);
    const Eigen::Vector2d p(range * std::cos(bearing), range * std::sin(bearing));
    add_end((T_base_laser * p).cast<float>());
  }
  pad_ends();
}

// Padding lies outside every map, where the likelihood is the floor.
void ScanWeigher::pad_ends() {
  while (end_x_.size() % 16 != 0) add_end({1e30F, 1e30F});
}

void ScanWeigher::pick_beams(const LaserScan& scan) {
  const std::size_t n = scan.ranges_m.size();
  const std::size_t count = std::min(n, at_least_one(options_.beams));
  longest_m_ = std::min(scan.max_range_m, static_cast<float>(options_.max_range_m));
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * n / count;
    const float range = scan.ranges_m[i];
    const bool returned = scan.returned(i) && range < longest_m_;
    // Below the sensor's minimum range, or not a number: not used.
    if (!returned && !(range >= longest_m_)) continue;
    const double bearing = scan.bearing(i).radians();
    cosines_.push_back(static_cast<float>(std::cos(bearing)));
    sines_.push_back(static_cast<float>(std::sin(bearing)));
    ranges_.push_back(returned ? range : 0.0F);
  }
}

void ScanWeigher::field_sums(const LikelihoodField& field, const ParticleSet& particles,
                             std::size_t begin, std::size_t count, std::uint32_t* sums) const {
  std::array<float, kBlock> c, s, ox, oy;
  const double scale = 1.0 / field.resolution_m();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = begin + k;
    c[k] = static_cast<float>(scale * std::cos(particles.heading_rad[i]));
    s[k] = static_cast<float>(scale * std::sin(particles.heading_rad[i]));
    ox[k] = static_cast<float>(particles.x_m[i] * scale - field.origin().x);
    oy[k] = static_cast<float>(particles.y_m[i] * scale - field.origin().y);
  }
  kernels::best_kernels().field_sums(
      {field.data(), field.stride(), field.width(), field.height()}, end_x_.data(), end_y_.data(),
      static_cast<int>(end_x_.size()),
      {c.data(), s.data(), ox.data(), oy.data(), static_cast<int>(count)}, sums);
}

void ScanWeigher::weigh_by_field(const LocalisationMap& map, bool broad,
                                 const ParticleSet& particles,
                                 std::span<double> log_likelihood) const {
  const LocalisationMap::Fields& fields = map.fields(sensor_);
  const LikelihoodField& field = broad ? fields.broad : fields.sharp;
  const double share = independent(broad) / static_cast<double>(std::max<std::size_t>(ends_, 1));
  const std::size_t blocks = (particles.size() + kBlock - 1) / kBlock;
  parallel_for(blocks, options_.threads, [&](std::size_t b) {
    std::array<std::uint32_t, kBlock> sums;
    const std::size_t begin = b * kBlock, count = std::min(kBlock, particles.size() - begin);
    field_sums(field, particles, begin, count, sums.data());
    for (std::size_t k = 0; k < count; ++k)
      log_likelihood[begin + k] = share * (field.log_floor() * static_cast<double>(ends_) +
                                           field.log_step() * static_cast<double>(sums[k]));
  });
}

void ScanWeigher::weigh_by_beams(const LocalisationMap& map, bool broad,
                                 const ParticleSet& particles,
                                 std::span<double> log_likelihood) const {
  const std::size_t n = ranges_.size();
  const double share = independent(broad) / static_cast<double>(std::max<std::size_t>(n, 1));
  const FieldShape& shape = map.options().lidar;
  const auto sigma = static_cast<float>(broad ? shape.search_sigma_m : shape.sigma_m);
  const BeamModel& beam = options_.beam;
  const auto log_of = [&](float measured, float expected) {
    const bool none_expected = expected >= longest_m_;
    if (measured == 0.0F) return none_expected ? 0.0 : std::log(beam.p_missed);
    const float off = (measured - expected) / sigma;
    const double floor = none_expected || off < 0.0F ? beam.p_short : beam.p_through;
    const double hit = std::exp(-0.5 * static_cast<double>(off) * static_cast<double>(off));
    return std::log(floor + (1.0 - floor) * hit);
  };
  const std::size_t blocks = (particles.size() + kBlock - 1) / kBlock;
  parallel_for(blocks, options_.threads, [&](std::size_t b) {
    std::vector<float> expected(n);
    const std::size_t begin = b * kBlock, end = std::min(begin + kBlock, particles.size());
    for (std::size_t i = begin; i < end; ++i) {
      map.rays().cast(particles.state(i) * options_.T_base_laser.raw(), cosines_, sines_,
                      static_cast<double>(longest_m_), expected);
      double sum = 0.0;
      for (std::size_t k = 0; k < n; ++k) sum += log_of(ranges_[k], expected[k]);
      log_likelihood[i] = share * sum;
    }
  });
}

void ScanWeigher::weigh(const LocalisationMap& map, bool broad, const ParticleSet& particles,
                        std::span<double> log_likelihood) const {
  if (options_.model == ScanLikelihood::beam && sensor_ == RangeSensor::lidar) {
    weigh_by_beams(map, broad, particles, log_likelihood);
  } else {
    weigh_by_field(map, broad, particles, log_likelihood);
  }
}

double ScanWeigher::agreement(const LocalisationMap& map, const SE2d& T_map_base) const {
  if (ends_ == 0) return 0.0;
  ParticleSet one;
  one.push_back(T_map_base);
  std::uint32_t sum = 0;
  field_sums(map.fields(sensor_).sharp, one, 0, 1, &sum);
  return static_cast<double>(sum) / (LikelihoodField::kMaxValue * static_cast<double>(ends_));
}

}  // namespace wayfare
