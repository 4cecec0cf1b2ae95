#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare {

/// Poses and log weights as a structure of arrays.
struct ParticleSet {
  std::vector<double> x_m, y_m, heading_rad, log_weight;

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
  [[nodiscard]] bool empty() const { return x_m.empty(); }
  [[nodiscard]] SE2d pose(std::size_t i) const {
    return {x_m[i], y_m[i], Angle::radians(heading_rad[i])};
  }
  void set(std::size_t i, const SE2d& pose) {
    x_m[i] = pose.x();
    y_m[i] = pose.y();
    heading_rad[i] = pose.heading().radians();
  }
  void resize(std::size_t n) {
    x_m.resize(n);
    y_m.resize(n);
    heading_rad.resize(n);
    log_weight.assign(n, 0.0);
  }
  void push_back(const SE2d& pose) {
    x_m.push_back(pose.x());
    y_m.push_back(pose.y());
    heading_rad.push_back(pose.heading().radians());
    log_weight.push_back(0.0);
  }
};

/// The weights, normalised.
[[nodiscard]] std::vector<double> weights_of(const ParticleSet& particles);

/// Bins of poses: counted by KLD sampling; adjacent ones form a cluster.
class PoseBins {
 public:
  /// Sides that are not positive become the smallest: 1 mm, 1/3600 of a turn.
  PoseBins(double side_m, Angle turn)
      : side_m_(side_m > 1e-3 ? side_m : 1e-3),
        turns_(turn.radians() > 2.0 * std::numbers::pi / kMostTurns
                   ? std::max(
                         1, static_cast<int>(std::lround(2.0 * std::numbers::pi / turn.radians())))
                   : kMostTurns) {}

  struct Key {
    std::int32_t x = 0, y = 0, turn = 0;
    auto operator<=>(const Key&) const = default;
  };
  [[nodiscard]] Key of(double x_m, double y_m, double heading_rad) const {
    const double turn = wrap_to_pi(heading_rad) / (2.0 * std::numbers::pi) + 0.5;
    const int k = static_cast<int>(turn * turns_);
    return {whole(x_m), whole(y_m), std::clamp(k, 0, turns_ - 1)};
  }
  [[nodiscard]] int turns() const { return turns_; }

 private:
  static constexpr int kMostTurns = 3600;

  [[nodiscard]] std::int32_t whole(double metres) const {
    return static_cast<std::int32_t>(std::clamp(std::floor(metres / side_m_), -1e9, 1e9));
  }
  double side_m_;
  int turns_;
};

/// Counts distinct bins. Open addressing; grows as it fills.
class BinCounter {
 public:
  /// Counts the bin if it is new, and returns whether it was.
  bool add(const PoseBins::Key& key) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    Slot& slot = find(key);
    if (slot.used) return false;
    slot = {key, true};
    ++count_;
    return true;
  }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  struct Slot {
    PoseBins::Key key;
    bool used = false;
  };
  Slot& find(const PoseBins::Key& key) {
    std::uint64_t hash = static_cast<std::uint32_t>(key.x) * 0x9e3779b97f4a7c15ULL;
    hash = (hash ^ static_cast<std::uint32_t>(key.y)) * 0xbf58476d1ce4e5b9ULL;
    hash = (hash ^ static_cast<std::uint32_t>(key.turn)) * 0x94d049bb133111ebULL;
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = static_cast<std::size_t>(hash >> 20) & mask;
    while (slots_[i].used && slots_[i].key != key) i = (i + 1) & mask;
    return slots_[i];
  }
  void grow() {
    std::vector<Slot> old(slots_.empty() ? 64 : 2 * slots_.size());
    std::swap(old, slots_);
    for (const Slot& s : old)
      if (s.used) find(s.key) = s;
  }
  std::vector<Slot> slots_;
  std::size_t count_ = 0;
};

/// Particles in adjacent bins; the heaviest cluster comes first.
struct Cluster {
  double mass = 0.0;
  std::vector<std::uint32_t> members;
};
[[nodiscard]] std::vector<Cluster> find_clusters(const ParticleSet& particles,
                                                 std::span<const double> weights,
                                                 const PoseBins& bins);

/// Fox 2003, equation (7): number of particles that bounds the Kullback-Leibler distance of a
/// histogram of `k` bins by the options' error.
[[nodiscard]] double kld_bound(std::size_t k, const LocalisationOptions& options);

/// Draws by weight, as many as KLD sampling requires, at least `least` and within the options'
/// limit.
[[nodiscard]] ParticleSet resample_adaptively(const ParticleSet& from, const PoseBins& bins,
                                              const LocalisationOptions& options, std::size_t least,
                                              Rng& rng);

/// `count` draws by weight, each with normal noise: separates copies of one particle.
[[nodiscard]] ParticleSet resample_with_noise(const ParticleSet& from, std::size_t count,
                                              double sigma_m, double sigma_rad, Rng& rng);

/// Poses evenly spread over the map's free cells, each at a random heading.
[[nodiscard]] ParticleSet uniform_poses(const LocalisationMap& map,
                                        const LocalisationOptions& options, const Rng& rng);

/// Moves every particle by its own sample of `motion`.
void move(ParticleSet& particles, const Gaussian<SE2d>& motion, int threads, const Rng& rng);

}  // namespace wayfare
