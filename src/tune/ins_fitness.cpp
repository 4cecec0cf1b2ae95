#include <wayfare/tune/ins_fitness.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/isa.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/parallel.hpp>
#include <wayfare/core/statistics.hpp>

#include "tune/intervals.hpp"
#include "tune/kernels/kernels.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
namespace kernel = fitness_kernels;

static_assert(kInsGenes == kernel::kGenes);

kernel::Quaternion coefficients(const SO3d& r) {
  const auto& q = r.quaternion();
  return {q.w(), q.x(), q.y(), q.z()};
}

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

/// The names of the kernels, the fastest first.
constexpr std::pair<const char*, Isa> kVariants[] = {
    {"avx512", Isa::avx512}, {"avx2", Isa::avx2}, {"baseline", Isa::baseline}};

ImuSample interpolate(const ImuSample& a, const ImuSample& b, LogTime t) {
  const double u = to_seconds(t - a.time) / to_seconds(b.time - a.time);
  return {t, a.angular_rate_radps + u * (b.angular_rate_radps - a.angular_rate_radps),
          a.specific_force_mps2 + u * (b.specific_force_mps2 - a.specific_force_mps2)};
}

/// Adds a drive to a problem as a sequence of steps: readings are split at the epochs, so that
/// every epoch ends a step.
class StepMaker {
 public:
  StepMaker(const TuningDrive& drive, double score_interval_s, kernel::Problem& to)
      : drive_(drive),
        interval_s_(score_interval_s),
        plane_(drive.start.nav.position),
        next_score_(drive.start.nav.time),
        to_(to) {}

  void run() {
    to_.anchors.push_back(plane_.anchor());
    auto epoch = std::find_if(drive_.ranges.begin(), drive_.ranges.end(),
                              [&](const RangeEpoch& e) { return e.time > next_score_; });
    std::optional<ImuSample> last;
    for (ImuSample s : drive_.imu) {
      s.time += from_seconds(drive_.options.imu_time_offset_s);
      if (s.time < drive_.start.nav.time || (last && s.time <= last->time)) continue;
      while (last && epoch != drive_.ranges.end() && epoch->time < s.time) {
        if (epoch->time > last->time) {
          const ImuSample cut = interpolate(*last, s, epoch->time);
          add(*last, cut, &*epoch);
          last = cut;
        }
        ++epoch;
      }
      if (last) {
        const bool ends = epoch != drive_.ranges.end() && epoch->time == s.time;
        add(*last, s, ends ? &*epoch : nullptr);
        if (ends) ++epoch;
      }
      last = s;
    }
    std::vector<double> intervals;
    for (const kernel::Step& s : to_.steps) intervals.push_back(s.imu.dt_s);
    to_.nominal_dt_s = upper_median_of(intervals);
    to_.by_intervals = kernel::divide_into_intervals(to_.steps);
  }

 private:
  void add(const ImuSample& from, const ImuSample& to, const RangeEpoch* epoch) {
    kernel::Step s{};
    s.imu = between(from, to);
    // As in the navigation system: exponential mean over half a second.
    const double gain = 1.0 - std::exp(-s.imu.dt_s / 0.5);
    const Vector3d change = to.angular_rate_radps - from.angular_rate_radps;
    s.vibration = vibration_ += gain * (0.5 * change.cwiseAbs2() - vibration_);
    s.first_satellite = to_.satellites.size();
    if (epoch)
      std::copy_if(epoch->satellites.begin(), epoch->satellites.end(),
                   std::back_inserter(to_.satellites), [](const CorrectedRange& r) {
                     return r.position_ecef_m.allFinite() && r.velocity_ecef_mps.allFinite();
                   });
    s.satellites = to_.satellites.size() - s.first_satellite;
    if (to.time >= next_score_) s.truth = truth(to.time);
    s.plane = to_.anchors.size() - 1;
    to_.steps.push_back(s);
  }

  std::optional<kernel::Truth> truth(LogTime time) {
    const auto state = drive_.truth(time);
    if (!state) return std::nullopt;
    next_score_ = time + from_seconds(interval_s_ - 1e-6);
    // The plane follows the truth, not a filter, so that it is the same for all.
    if (plane_.offset(state->position).norm() > 5000.0) {
      plane_ = LocalTangentPlane(state->position);
      to_.anchors.push_back(plane_.anchor());
    }
    // A heading from the course over ground is valid only in motion.
    const bool moves = state->velocity_ned_mps.head<2>().norm() > 3.0;
    return kernel::Truth{plane_.offset(state->position), coefficients(state->q_nb),
                         drive_.has_level, drive_.has_heading && (drive_.has_level || moves)};
  }

  const TuningDrive& drive_;
  double interval_s_;
  LocalTangentPlane plane_;
  LogTime next_score_;
  kernel::Problem& to_;
  Vector3d vibration_ = Vector3d::Zero();
};

/// Initialises the receiver clock from the first epoch's ranges and rates.
void set_clock(const TuningDrive& drive, kernel::Problem& p) {
  p.clock_sigma_m = 100.0;
  p.clock_drift_sigma_mps = 10.0;
  const auto epoch = std::find_if(
      drive.ranges.begin(), drive.ranges.end(),
      [&](const RangeEpoch& e) { return e.time > drive.start.nav.time && !e.satellites.empty(); });
  if (epoch == drive.ranges.end()) return;
  const NavState at = drive.truth(epoch->time).value_or(drive.start.nav);
  const Vector3d here = ecef_from_geodetic(at.position);
  const Vector3d velocity = rotation_ecef_ned(at.position) * at.velocity_ned_mps;
  std::vector<double> bias, drift;
  for (const CorrectedRange& r : epoch->satellites) {
    const Vector3d d = r.position_ecef_m - here;
    if (std::isfinite(r.range_m)) bias.push_back(r.range_m - d.norm());
    if (std::isfinite(r.range_rate_mps))
      drift.push_back(r.range_rate_mps - d.normalized().dot(r.velocity_ecef_mps - velocity));
  }
  p.clock_drift_mps = upper_median_of(drift);
  p.clock_bias_m =
      upper_median_of(bias) - p.clock_drift_mps * to_seconds(epoch->time - drive.start.nav.time);
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

double InsFitnessWeights::sum(const InsRmse& e) const {
  return north * e.north_m + east * e.east_m + down * e.down_m + roll * e.roll_deg +
         pitch * e.pitch_deg + heading * e.heading_deg;
}

struct InsFitness::Content {
  kernel::Problem problem{};
  const char* name = "";
  kernel::Kernel kernel{};
  InsFitnessOptions options;

  Content(const TuningDrive& drive, const InsFitnessOptions& with) : options(with) {
    kernel::Problem& p = problem;
    StepMaker(drive, options.score_interval_s, p).run();
    const GnssInsStart& s = drive.start;
    p.start_velocity_mps = s.nav.velocity_ned_mps;
    p.start_q_nb = coefficients(s.nav.q_nb);
    p.q_body_imu = coefficients(drive.options.q_body_imu);
    p.position_sigma_m = s.position_sigma_m;
    p.velocity_sigma_mps = s.velocity_sigma_mps;
    p.level_sigma_rad = s.level_sigma_rad;
    p.heading_sigma_rad = s.heading_sigma_rad;
    p.lever_imu_m = drive.options.q_body_imu.inverse() * drive.options.antenna_lever_arm_m;
    p.gate_sigma = drive.options.gate_sigma;
    p.vibration_share = drive.options.gyro_vibration_share;
    set_clock(drive, p);
    p.by_intervals = p.by_intervals && !options.covariance_every_step;
  }
};

Result<InsFitness> InsFitness::make(const TuningDrive& drive, const InsFitnessOptions& options) {
  WAYFARE_EXPECTS(static_cast<bool>(drive.truth), "a tuning drive needs a truth");
  if (!(options.score_interval_s >= 0.0) || !std::isfinite(drive.options.imu_time_offset_s))
    return Error{ErrorCode::invalid, "score interval or time offset is not a number of seconds"};
  auto content = std::make_shared<Content>(drive, options);
  const kernel::Problem& problem = content->problem;
  if (problem.steps.empty() || problem.satellites.empty())
    return Error{ErrorCode::invalid, "there are no readings or no ranges after the start"};
  if (std::none_of(problem.steps.begin(), problem.steps.end(),
                   [](const kernel::Step& s) { return s.truth.has_value(); }))
    return Error{ErrorCode::invalid, "the reference does not overlap the recording"};
  const auto chosen =
      std::find_if(std::begin(kVariants), std::end(kVariants), [&options](const auto& v) {
        return runs_here(v.second) && (options.kernel.empty() || options.kernel == v.first);
      });
  if (chosen == std::end(kVariants))
    return Error{ErrorCode::unsupported, "no kernel '" + options.kernel + "' on this processor"};
  content->name = chosen->first;
  content->kernel = kernel::kernel_for(chosen->second);
  InsFitness fitness;
  fitness.content_ = std::move(content);
  return fitness;
}

std::vector<InsRmse> InsFitness::rmse(std::span<const double> individuals,
                                      const std::function<void(double)>& progress) const {
  const Content& c = *content_;
  const std::size_t n = individuals.size() / kInsGenes;
  const auto lanes = static_cast<std::size_t>(c.kernel.lanes);
  std::vector<InsRmse> all(n);
  const auto block = [&](std::size_t b) {
    std::vector<double> genes(kInsGenes * lanes), scores(kernel::kScores * lanes);
    for (std::size_t i = 0; i < lanes; ++i) {
      const std::size_t individual = std::min(b * lanes + i, n - 1);
      for (std::size_t g = 0; g < kInsGenes; ++g)
        genes[g * lanes + i] = individuals[individual * kInsGenes + g];
    }
    c.kernel.evaluate(c.problem, genes.data(), scores.data());
    constexpr double kDegree = std::numbers::pi / 180.0;
    for (std::size_t i = 0; i < lanes && b * lanes + i < n; ++i) {
      const auto of = [&](std::size_t k) { return scores[k * lanes + i]; };
      all[b * lanes + i] = {of(0), of(1), of(2), of(3) / kDegree, of(4) / kDegree, of(5) / kDegree};
    }
  };
  parallel_for((n + lanes - 1) / lanes, c.options.threads, block, progress);
  return all;
}

void InsFitness::operator()(std::span<const double> individuals, std::span<double> scores,
                            const std::function<void(double)>& progress) const {
  const auto all = rmse(individuals, progress);
  for (std::size_t i = 0; i < all.size() && i < scores.size(); ++i) {
    const double s = content_->options.weights.sum(all[i]);
    scores[i] = std::isfinite(s) ? s : std::numeric_limits<double>::infinity();
  }
}

std::string InsFitness::kernel() const { return content_->name; }

}  // namespace wayfare
