#include "slam/localisation/particle_set.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include <wayfare/core/parallel.hpp>
#include <wayfare/filter/particles.hpp>
#include <wayfare/motion/differential_drive_model.hpp>

namespace wayfare {
namespace {

constexpr std::size_t kBlock = 1024;  // draws per random stream, independent of the threads

template <class F>
void for_blocks(std::size_t n, int threads, const Rng& rng, const F& f) {
  parallel_for((n + kBlock - 1) / kBlock, threads, [&](std::size_t b) {
    Rng own = rng.stream(b);
    for (std::size_t i = b * kBlock; i < std::min(n, (b + 1) * kBlock); ++i) f(i, own);
  });
}

std::vector<double> cumulated_weights(const ParticleSet& set) {
  const double max = max_log_weight(set.log_weight);
  std::vector<double> sums;
  sums.reserve(set.size());
  double sum = 0.0;
  for (const double l : set.log_weight)
    sums.push_back(sum += std::isfinite(max) ? relative_weight(l, max) : 1.0);
  return sums;
}

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

std::vector<double> weights_of(const ParticleSet& particles) {
  std::vector<double> weights = particles.log_weight;
  normalise(weights);
  for (double& w : weights) w = std::exp(w);
  return weights;
}

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

double kld_bound(std::size_t k, const LocalisationOptions& options) {
  if (k < 2) return 1.0;
  const double freedom = static_cast<double>(k - 1), ninth = 2.0 / (9.0 * freedom);
  const double cube = 1.0 - ninth + std::sqrt(ninth) * options.kld_quantile;
  return freedom / (2.0 * options.kld_error) * cube * cube * cube;
}

// Single draws determine the number; the sample itself is drawn with low variance, so that neither
// of two equally likely poses wins by chance.
ParticleSet resample_adaptively(const ParticleSet& from, const PoseBins& bins,
                                const LocalisationOptions& options, std::size_t least, Rng& rng) {
  const std::vector<double> sums = cumulated_weights(from);
  const std::size_t most = std::max(options.max_particles, options.min_particles);
  BinCounter seen;
  auto wanted = static_cast<double>(std::max<std::size_t>(least, 1));
  std::size_t n = 0;
  for (; static_cast<double>(n) < wanted && n < most; ++n) {
    const double at = rng.uniform() * sums.back();
    const auto i = static_cast<std::size_t>(
        std::min(std::upper_bound(sums.begin(), sums.end(), at) - sums.begin(),
                 static_cast<std::ptrdiff_t>(sums.size()) - 1));
    if (seen.add(bins.of(from.x_m[i], from.y_m[i], from.heading_rad[i])))
      wanted = std::max(wanted, kld_bound(seen.count(), options));
  }
  ParticleSet drawn;
  for (const ParticleIndex i : resample(from.log_weight, n, Resampling::low_variance, rng))
    drawn.push_back(from.pose(i));
  return drawn;
}

ParticleSet resample_with_noise(const ParticleSet& from, std::size_t count, double sigma_m,
                                double sigma_rad, Rng& rng) {
  ParticleSet drawn;
  for (const ParticleIndex i : resample(from.log_weight, count, Resampling::low_variance, rng)) {
    const double x = from.x_m[i] + sigma_m * rng.normal();
    const double y = from.y_m[i] + sigma_m * rng.normal();
    drawn.push_back(SE2d(x, y, Angle::radians(from.heading_rad[i] + sigma_rad * rng.normal())));
  }
  return drawn;
}

ParticleSet uniform_poses(const LocalisationMap& map, const LocalisationOptions& options,
                          const Rng& rng) {
  const double cell_m = map.resolution_m();
  const auto places = static_cast<double>(map.free_cells().size());
  const double wanted = options.candidates_per_m2 * places * cell_m * cell_m;
  const double most = static_cast<double>(std::max<std::size_t>(options.max_candidates, 1));
  const double least = std::min(static_cast<double>(options.min_candidates), most);
  ParticleSet poses;
  // In this order NaN gives the least.
  poses.resize(static_cast<std::size_t>(std::min(std::max({1.0, least, wanted}), most)));
  const double stride = places / static_cast<double>(poses.size());
  for_blocks(poses.size(), options.threads, rng, [&](std::size_t i, Rng& own) {
    const double at = (static_cast<double>(i) + own.uniform()) * stride;
    const auto place = std::min(static_cast<std::size_t>(at), map.free_cells().size() - 1);
    const Cell& c = map.free_cells()[place];
    poses.x_m[i] = (c.x + own.uniform()) * cell_m;
    poses.y_m[i] = (c.y + own.uniform()) * cell_m;
    poses.heading_rad[i] = own.uniform(-std::numbers::pi, std::numbers::pi);
  });
  return poses;
}

void move(ParticleSet& particles, const Gaussian<SE2d>& motion, int threads, const Rng& rng) {
  const MotionSampler draw(motion);
  for_blocks(particles.size(), threads, rng,
             [&](std::size_t i, Rng& own) { particles.set(i, particles.pose(i) * draw(own)); });
}

}  // namespace wayfare
