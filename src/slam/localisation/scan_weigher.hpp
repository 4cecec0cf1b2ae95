#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/slam/localisation.hpp>

#include "slam/localisation/particle_set.hpp"

namespace wayfare {

/// One scan's beams, selected and laid out for weighting many poses.
class ScanWeigher {
 public:
  ScanWeigher(const LaserScan& scan, const LocalisationOptions& options);
  /// Of a radar's points in the base frame.
  ScanWeigher(const PointSet& points, const LocalisationOptions& options);

  [[nodiscard]] RangeSensor sensor() const { return sensor_; }

  /// Whether there are enough beams.
  [[nodiscard]] bool enough() const { return enough_; }

  /// log_likelihood[i] = ln p(scan | particle i), scaled to the options' number of independent
  /// beams; with the map's broad fields or the sharp ones.
  void weigh(const LocalisationMap& map, bool broad, const ParticleSet& particles,
             std::span<double> log_likelihood) const;
  /// Of the poses of a search: with the broad likelihood field, whatever the options' model.
  void weigh_candidates(const LocalisationMap& map, const ParticleSet& particles,
                        std::span<double> log_likelihood) const {
    weigh_by_field(map, true, particles, log_likelihood);
  }
  /// Mean likelihood of the end points at one pose, in [0, 1].
  [[nodiscard]] double agreement(const LocalisationMap& map, const SE2d& T_map_base) const;

 private:
  [[nodiscard]] double independent(bool broad) const {
    if (sensor_ == RangeSensor::radar)
      return broad ? options_.radar.independent_unconverged : options_.radar.independent_points;
    return broad ? options_.independent_unconverged : options_.independent_beams;
  }
  void weigh_by_field(const LocalisationMap& map, bool broad, const ParticleSet& particles,
                      std::span<double> log_likelihood) const;
  void weigh_by_beams(const LocalisationMap& map, bool broad, const ParticleSet& particles,
                      std::span<double> log_likelihood) const;
  void pick_ends(const LaserScan& scan);
  void pick_beams(const LaserScan& scan);
  void add_end(const Eigen::Vector2f& p_base) {
    end_x_.push_back(p_base.x());
    end_y_.push_back(p_base.y());
  }
  void pad_ends();
  void field_sums(const LikelihoodField& field, const ParticleSet& particles, std::size_t begin,
                  std::size_t count, std::uint32_t* sums) const;

  const LocalisationOptions& options_;
  RangeSensor sensor_ = RangeSensor::lidar;
  bool enough_ = false;
  std::size_t ends_ = 0;              // without padding
  std::vector<float> end_x_, end_y_;  // of the selected returns in the base frame, padded to 16
  std::vector<float> cosines_, sines_, ranges_;  // of the selected beams; 0: no return
  float longest_m_ = 0.0F;                       // least range of a beam without return
};

/// The library's likelihoods of scans, by the options' choice.
class ScanModels {
 public:
  static constexpr std::size_t kSensors = 2;
  using Storage = ParticleSet;

  explicit ScanModels(std::shared_ptr<const LocalisationOptions> options)
      : options_(std::move(options)) {}

  [[nodiscard]] ScanWeigher prepare(const LaserScan& scan) const { return {scan, *options_}; }
  [[nodiscard]] ScanWeigher prepare(const PointSet& points_base) const {
    return {points_base, *options_};
  }

 private:
  std::shared_ptr<const LocalisationOptions> options_;
};

}  // namespace wayfare
