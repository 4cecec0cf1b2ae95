#include <numeric>
#include <utility>

#include "slam/localisation/pose_bins.hpp"

namespace wayfare {
namespace {

/// The occupied bins in order, each with its particles.
struct BinnedParticles {
  std::vector<PoseBins::Key> keys;
  std::vector<std::uint32_t> first;  // bin b holds order[first[b] .. first[b + 1])
  std::vector<std::uint32_t> order;
};

BinnedParticles bin(const ParticleSet& particles, const PoseBins& bins) {
  std::vector<std::pair<PoseBins::Key, std::uint32_t>> keyed;
  keyed.reserve(particles.size());
  for (std::uint32_t i = 0; i < particles.size(); ++i)
    keyed.emplace_back(bins.of(particles.x_m[i], particles.y_m[i], particles.heading_rad[i]), i);
  std::sort(keyed.begin(), keyed.end());
  BinnedParticles result;
  for (const auto& [key, i] : keyed) {
    if (result.keys.empty() || result.keys.back() != key) {
      result.keys.push_back(key);
      result.first.push_back(static_cast<std::uint32_t>(result.order.size()));
    }
    result.order.push_back(i);
  }
  result.first.push_back(static_cast<std::uint32_t>(result.order.size()));
  return result;
}

class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0U); }
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

}  // namespace

std::vector<Cluster> find_clusters(const ParticleSet& particles, std::span<const double> weights,
                                   const PoseBins& bins) {
  const BinnedParticles binned = bin(particles, bins);
  Sets sets(binned.keys.size());
  const auto join_with = [&](std::uint32_t b, const PoseBins::Key& key) {
    const auto at = std::lower_bound(binned.keys.begin(), binned.keys.end(), key);
    if (at != binned.keys.end() && *at == key)
      sets.join(b, static_cast<std::uint32_t>(at - binned.keys.begin()));
  };
  for (std::uint32_t b = 0; b < binned.keys.size(); ++b)
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dt = -1; dt <= 1; ++dt) {
          const PoseBins::Key& k = binned.keys[b];
          join_with(b, {k.x + dx, k.y + dy, (k.turn + dt + bins.turns()) % bins.turns()});
        }
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
