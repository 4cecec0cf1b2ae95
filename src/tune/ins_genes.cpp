#include <wayfare/tune/ins_fitness.hpp>

#include <array>
#include <string>

#include <wayfare/core/contract.hpp>

namespace wayfare {
namespace {

struct Triple {
  const char* name;
  bool is_tau;
  Eigen::Vector3d& value;
};

std::array<Triple, 10> triples(ImuNoise& n) {
  return {{{"gyro_bias_sigma", false, n.gyro_bias_radps.sigma},
           {"gyro_bias_tau", true, n.gyro_bias_radps.tau_s},
           {"gyro_scale_sigma", false, n.gyro_scale.sigma},
           {"gyro_scale_tau", true, n.gyro_scale.tau_s},
           {"accel_bias_sigma", false, n.accel_bias_mps2.sigma},
           {"accel_bias_tau", true, n.accel_bias_mps2.tau_s},
           {"accel_scale_sigma", false, n.accel_scale.sigma},
           {"accel_scale_tau", true, n.accel_scale.tau_s},
           {"gyro_white", false, n.gyro_white_rad_per_sqrt_s},
           {"accel_white", false, n.accel_white_mps_per_sqrt_s}}};
}

}  // namespace

std::vector<double> ins_genes(const GnssInsOptions& options) {
  ImuNoise imu = options.imu;
  std::vector<double> genes;
  for (const Triple& t : triples(imu))
    for (int i = 0; i < 3; ++i) genes.push_back(t.value[i]);
  genes.push_back(options.clock.bias_walk_m_per_sqrt_s);
  genes.push_back(options.clock.drift_walk_mps_per_sqrt_s);
  genes.push_back(options.range_sigma_scale);
  return genes;
}

GnssInsOptions with_ins_genes(const GnssInsOptions& options, std::span<const double> genes) {
  WAYFARE_EXPECTS(genes.size() == kInsGenes, "33 genes");
  GnssInsOptions o = options;
  std::size_t g = 0;
  for (const Triple& t : triples(o.imu))
    for (int i = 0; i < 3; ++i) t.value[i] = genes[g++];
  o.clock.bias_walk_m_per_sqrt_s = genes[g++];
  o.clock.drift_walk_mps_per_sqrt_s = genes[g++];
  o.range_sigma_scale = genes[g++];
  return o;
}

std::vector<Gene> ins_gene_bounds(const GnssInsOptions& nominal, const InsGeneSpans& spans) {
  const std::vector<double> at = ins_genes(nominal);
  std::vector<Gene> genes;
  const auto add = [&](const std::string& name, double span) {
    const double v = at[genes.size()];
    genes.push_back({name, v / span, v * span, true});
  };
  ImuNoise imu = nominal.imu;
  for (const Triple& t : triples(imu))
    for (const char* axis : {"_x", "_y", "_z"})
      add(std::string(t.name) + axis, t.is_tau ? spans.tau : spans.noise);
  add("clock_bias_walk", spans.clock);
  add("clock_drift_walk", spans.clock);
  add("range_sigma_scale", spans.range_scale);
  return genes;
}

}  // namespace wayfare
