#pragma once

// Bins of poses, and clusters of particles in adjacent bins.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/detail/bin_counter.hpp>

namespace wayfare {

namespace detail {

/// Bins of lengths and of a full turn. Sides that are not positive become the smallest: 1 mm,
/// 1/3600 of a turn.
class BinSides {
 public:
  BinSides(double side_m, Angle turn)
      : side_m_(side_m > 1e-3 ? side_m : 1e-3),
        turns_(turn.radians() > 2.0 * std::numbers::pi / kMostTurns
                   ? std::max(
                         1, static_cast<int>(std::lround(2.0 * std::numbers::pi / turn.radians())))
                   : kMostTurns) {}

  [[nodiscard]] int turns() const { return turns_; }
  [[nodiscard]] std::int32_t whole(double metres) const {
    return static_cast<std::int32_t>(std::clamp(std::floor(metres / side_m_), -1e9, 1e9));
  }
  [[nodiscard]] std::int32_t of_turn(double radians) const {
    const double turn = wrap_to_pi(radians) / (2.0 * std::numbers::pi) + 0.5;
    return std::clamp(static_cast<int>(turn * turns_), 0, turns_ - 1);
  }
  [[nodiscard]] std::int32_t wrapped(std::int32_t turn) const { return (turn + turns_) % turns_; }

 private:
  static constexpr int kMostTurns = 3600;
  double side_m_;
  int turns_;
};

}  // namespace detail

/// Bins of poses in the plane, along x, y and heading: counted by KLD sampling; adjacent ones form
/// a cluster.
class PoseBins : detail::BinSides {
 public:
  using Key = BinKey<3>;  ///< along x, y and heading
  using BinSides::BinSides, BinSides::turns;

  /// The bin of a pose given by its coordinates.
  [[nodiscard]] Key of(double x_m, double y_m, double heading_rad) const {
    return {whole(x_m), whole(y_m), of_turn(heading_rad)};
  }
  /// The bin of a pose.
  [[nodiscard]] Key operator()(const SE2d& pose) const {
    return of(pose.x(), pose.y(), pose.heading().radians());
  }
  /// The bin at `offset` from another; headings wrap.
  [[nodiscard]] Key beside(const Key& key, const Key& offset) const {
    return {key[0] + offset[0], key[1] + offset[1], wrapped(key[2] + offset[2])};
  }
};

/// The same in space: along x, y, z, roll, pitch and yaw.
class SpatialPoseBins : detail::BinSides {
 public:
  using Key = BinKey<6>;  ///< along x, y, z, roll, pitch and yaw
  using BinSides::BinSides, BinSides::turns;

  /// The bin of a pose.
  [[nodiscard]] Key operator()(const SE3d& pose) const {
    const Eigen::Vector3d& t = pose.translation();
    const Eigen::Vector3d turn = roll_pitch_yaw_rad(pose.rotation());
    return {whole(t[0]),      whole(t[1]),      whole(t[2]),
            of_turn(turn[0]), of_turn(turn[1]), of_turn(turn[2])};
  }
  /// The bin at `offset` from another; roll and yaw wrap.
  [[nodiscard]] Key beside(const Key& key, const Key& offset) const {
    Key moved;
    for (std::size_t k = 0; k < 6; ++k) moved[k] = key[k] + offset[k];
    for (const std::size_t cyclic : {3U, 5U}) moved[cyclic] = wrapped(moved[cyclic]);
    return moved;
  }
};

/// Particles in adjacent bins.
struct Cluster {
  double mass = 0.0;                   ///< sum of their weights
  std::vector<std::uint32_t> members;  ///< their indices
};

namespace detail {

/// The occupied bins in order, each with its particles.
template <class Key>
struct BinnedParticles {
  std::vector<Key> keys;
  std::vector<std::uint32_t> first;  // bin b holds order[first[b] .. first[b + 1])
  std::vector<std::uint32_t> order;

  explicit BinnedParticles(std::span<const Key> of_particles) {
    std::vector<std::pair<Key, std::uint32_t>> keyed;
    keyed.reserve(of_particles.size());
    for (const Key& key : of_particles)
      keyed.emplace_back(key, static_cast<std::uint32_t>(keyed.size()));
    std::sort(keyed.begin(), keyed.end());
    for (const auto& [key, i] : keyed) {
      if (keys.empty() || keys.back() != key) {
        keys.push_back(key);
        first.push_back(static_cast<std::uint32_t>(order.size()));
      }
      order.push_back(i);
    }
    first.push_back(static_cast<std::uint32_t>(order.size()));
  }
};

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Calls f for every offset in {−1, 0, 1}ᴺ.
template <std::size_t N, class F>
void for_adjacent(const F& f) {
  int count = 1;
  for (std::size_t k = 0; k < N; ++k) count *= 3;
  for (int i = 0; i < count; ++i) {
    BinKey<N> offset;
    for (std::size_t k = N, rest = static_cast<std::size_t>(i); k-- > 0; rest /= 3)
      offset[k] = static_cast<std::int32_t>(rest % 3) - 1;
    f(offset);
  }
}

}  // namespace detail

/// Clusters of particles whose bins are given, of normalised weights; the heaviest comes first.
/// `bins` tells which are adjacent, `beside(key, offset)`.
template <class Bins>
[[nodiscard]] std::vector<Cluster> find_clusters(std::span<const typename Bins::Key> of_particles,
                                                 std::span<const double> weights,
                                                 const Bins& bins) {
  using Key = typename Bins::Key;
  const detail::BinnedParticles<Key> binned(of_particles);
  detail::DisjointSets sets(binned.keys.size());
  for (std::uint32_t b = 0; b < binned.keys.size(); ++b)
    detail::for_adjacent<std::tuple_size_v<Key>>([&](const Key& offset) {
      const Key key = bins.beside(binned.keys[b], offset);
      const auto at = std::lower_bound(binned.keys.begin(), binned.keys.end(), key);
      if (at != binned.keys.end() && *at == key)
        sets.join(b, static_cast<std::uint32_t>(at - binned.keys.begin()));
    });
  std::vector<Cluster> clusters;
  std::vector<std::int64_t> cluster_of(binned.keys.size(), -1);
  for (std::uint32_t b = 0; b < binned.keys.size(); ++b) {
    std::int64_t& at = cluster_of[sets.root(b)];
    if (at < 0) {
      at = static_cast<std::int64_t>(clusters.size());
      clusters.emplace_back();
    }
    Cluster& cluster = clusters[static_cast<std::size_t>(at)];
    for (std::uint32_t i = binned.first[b]; i < binned.first[b + 1]; ++i) {
      cluster.members.push_back(binned.order[i]);
      cluster.mass += weights[binned.order[i]];
    }
  }
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const Cluster& a, const Cluster& b) { return a.mass > b.mass; });
  return clusters;
}

}  // namespace wayfare
