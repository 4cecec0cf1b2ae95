#pragma once

// The 33 tuned parameters of the navigation filter, in the order of Zhang 2020, table 2: σ and τ of
// gyro bias, gyro scale, accelerometer bias and accelerometer scale (three axes each), white noise
// of gyros and accelerometers, random walks of the clock's bias and drift, scale of the ranges'
// standard deviations.

#include <cstddef>
#include <span>
#include <vector>

#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/tune/genetic.hpp>

namespace wayfare {

inline constexpr std::size_t kInsGenes = 33;

/// Largest ratio of a parameter to its nominal value and vice versa.
struct InsGeneSpans {
  double noise = 30.0;  ///< standard deviations and white noises
  double tau = 30.0;
  double clock = 30.0;
  double range_scale = 10.0;
};

[[nodiscard]] std::vector<double> ins_genes(const GnssInsOptions& options);
/// `options` with these 33 parameters replaced.
[[nodiscard]] GnssInsOptions with_ins_genes(const GnssInsOptions& options,
                                            std::span<const double> genes);
/// Logarithmic bounds around the nominal parameters.
[[nodiscard]] std::vector<Gene> ins_gene_bounds(const GnssInsOptions& nominal,
                                                const InsGeneSpans& spans = {});

}  // namespace wayfare
