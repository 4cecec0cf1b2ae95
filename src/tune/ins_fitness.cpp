#include <wayfare/tune/ins_fitness.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/isa.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/parallel.hpp>

#include "tune/kernels/kernels.hpp"

namespace wayfare {
namespace {

using Eigen::Vector3d;
namespace kernel = fitness_kernels;

static_assert(kInsGenes == kernel::kGenes);

void put(const Vector3d& v, double* to) { std::copy_n(v.data(), 3, to); }
void put(const SO3d& r, double* to) {
  const auto& q = r.quaternion();
  to[0] = q.w(), to[1] = q.x(), to[2] = q.y(), to[3] = q.z();
}

struct Variant {
  const char* name;
  Isa isa;
};
/// The fastest first.
constexpr Variant kVariants[] = {
    {"avx512", Isa::avx512}, {"avx2", Isa::avx2}, {"baseline", Isa::baseline}};

ImuSample interpolate(const ImuSample& a, const ImuSample& b, LogTime t) {
  const double u = to_seconds(t - a.time) / to_seconds(b.time - a.time);
  return {t, a.angular_rate_radps + u * (b.angular_rate_radps - a.angular_rate_radps),
          a.specific_force_mps2 + u * (b.specific_force_mps2 - a.specific_force_mps2)};
}

/// A drive as a sequence of steps: readings are split at the epochs, so that every epoch ends a
/// step.
class Layout {
 public:
  std::vector<kernel::Step> steps;
  std::vector<kernel::Satellite> satellites;
  std::vector<kernel::Truth> truths;
  std::vector<kernel::Anchor> anchors;
  double nominal_dt_s = 0.0;

  Layout(const TuningDrive& drive, const InsFitnessOptions& options)
      : drive_(drive), interval_s_(options.score_interval_s), plane_(drive.start.nav.position) {
    add_anchor();
    next_score_ = drive.start.nav.time;
    auto epoch = std::find_if(drive.ranges.begin(), drive.ranges.end(),
                              [&](const RangeEpoch& e) { return e.time > drive.start.nav.time; });
    std::optional<ImuSample> last;
    for (ImuSample s : drive.imu) {
      s.time += from_seconds(drive.options.imu_time_offset_s);
      if (s.time < drive.start.nav.time || (last && s.time <= last->time)) continue;
      while (last && epoch != drive.ranges.end() && epoch->time < s.time) {
        if (epoch->time > last->time) {
          const ImuSample cut = interpolate(*last, s, epoch->time);
          add(*last, cut, &*epoch);
          last = cut;
        }
        ++epoch;
      }
      if (last) {
        const bool ends = epoch != drive.ranges.end() && epoch->time == s.time;
        add(*last, s, ends ? &*epoch : nullptr);
        if (ends) ++epoch;
      }
      last = s;
    }
    find_nominal_dt();
  }

 private:
  void add_anchor() {
    const Geodetic& a = plane_.anchor();
    anchors.push_back({a.latitude.radians(), a.longitude.radians(), a.height_m});
  }

  void add(const ImuSample& from, const ImuSample& to, const RangeEpoch* epoch) {
    kernel::Step s{};
    put(from.angular_rate_radps, s.begin_rate);
    put(to.angular_rate_radps, s.end_rate);
    put(from.specific_force_mps2, s.begin_force);
    put(to.specific_force_mps2, s.end_force);
    s.dt_s = to_seconds(to.time - from.time);
    update_vibration(from, to, s.dt_s);
    put(vibration_, s.vibration);
    s.truth = -1;
    s.first_satellite = static_cast<int>(satellites.size());
    if (epoch) add_satellites(*epoch);
    s.satellites = static_cast<int>(satellites.size()) - s.first_satellite;
    s.plane = static_cast<int>(anchors.size()) - 1;
    if (to.time >= next_score_) add_truth(to.time, s);
    steps.push_back(s);
  }

  /// As in the navigation system: exponential mean over half a second.
  void update_vibration(const ImuSample& from, const ImuSample& to, double dt_s) {
    const double gain = 1.0 - std::exp(-dt_s / 0.5);
    const Vector3d step = to.angular_rate_radps - from.angular_rate_radps;
    vibration_ += gain * (0.5 * step.cwiseAbs2() - vibration_);
  }

  void add_satellites(const RangeEpoch& epoch) {
    for (const CorrectedRange& r : epoch.satellites) {
      kernel::Satellite s{};
      put(r.position_ecef_m, s.position_ecef_m);
      put(r.velocity_ecef_mps, s.velocity_ecef_mps);
      s.range_m = r.range_m;
      s.range_rate_mps = r.range_rate_mps;
      s.range_sigma_m = r.range_sigma_m;
      s.range_rate_sigma_mps = r.range_rate_sigma_mps;
      s.has_range = std::isfinite(r.range_m) && r.range_sigma_m > 0.0;
      s.has_rate = std::isfinite(r.range_rate_mps) && r.range_rate_sigma_mps > 0.0;
      if (r.position_ecef_m.allFinite() && r.velocity_ecef_mps.allFinite()) satellites.push_back(s);
    }
  }

  void add_truth(LogTime time, kernel::Step& s) {
    const auto state = drive_.truth(time);
    if (!state) return;
    next_score_ = time + from_seconds(interval_s_ - 1e-6);
    Vector3d at = plane_.offset(state->position);
    // The plane follows the truth, not a filter, so that it is the same for all.
    if (at.norm() > 5000.0) {
      plane_ = LocalTangentPlane(state->position);
      add_anchor();
      at.setZero();
      s.plane = static_cast<int>(anchors.size()) - 1;
    }
    kernel::Truth t{};
    put(at, t.offset_m);
    put(state->q_nb, t.q_nb);
    t.has_level = drive_.has_level;
    // A heading from the course over ground is valid only in motion.
    t.has_heading =
        drive_.has_heading && (drive_.has_level || state->velocity_ned_mps.head<2>().norm() > 3.0);
    s.truth = static_cast<int>(truths.size());
    truths.push_back(t);
  }

  void find_nominal_dt() {
    if (steps.empty()) return;
    std::vector<double> all;
    for (const kernel::Step& s : steps) all.push_back(s.dt_s);
    std::nth_element(all.begin(), all.begin() + std::ssize(all) / 2, all.end());
    nominal_dt_s = all[all.size() / 2];
  }

  const TuningDrive& drive_;
  double interval_s_;
  LocalTangentPlane plane_;
  LogTime next_score_;
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
  const auto median = [](std::vector<double>& v) {
    if (v.empty()) return 0.0;
    std::nth_element(v.begin(), v.begin() + std::ssize(v) / 2, v.end());
    return v[v.size() / 2];
  };
  p.clock_drift_mps = median(drift);
  p.clock_bias_m =
      median(bias) - p.clock_drift_mps * to_seconds(epoch->time - drive.start.nav.time);
}

}  // namespace

double InsFitnessWeights::sum(const InsRmse& e) const {
  return north * e.north_m + east * e.east_m + down * e.down_m + roll * e.roll_deg +
         pitch * e.pitch_deg + heading * e.heading_deg;
}

struct InsFitness::Content {
  Layout layout;
  kernel::Problem problem{};
  const char* name = "";
  kernel::Kernel kernel{};
  InsFitnessOptions options;

  Content(const TuningDrive& drive, const InsFitnessOptions& with)
      : layout(drive, with), options(with) {
    kernel::Problem& p = problem;
    p.steps = layout.steps.data();
    p.step_count = static_cast<int>(layout.steps.size());
    p.nominal_dt_s = layout.nominal_dt_s;
    p.satellites = layout.satellites.data();
    p.truths = layout.truths.data();
    p.anchors = layout.anchors.data();
    const GnssInsStart& s = drive.start;
    put(Vector3d::Zero(), p.start_offset_m);
    put(s.nav.velocity_ned_mps, p.start_velocity_mps);
    put(s.nav.q_nb, p.start_q_nb);
    put(drive.options.q_body_imu, p.q_body_imu);
    p.position_sigma_m = s.position_sigma_m;
    p.velocity_sigma_mps = s.velocity_sigma_mps;
    p.level_sigma_rad = s.level_sigma_rad;
    p.heading_sigma_rad = s.heading_sigma_rad;
    put(Vector3d(drive.options.q_body_imu.inverse() * drive.options.antenna_lever_arm_m),
        p.lever_imu_m);
    p.gate_sigma = drive.options.gate_sigma;
    p.vibration_share = drive.options.gyro_vibration_share;
    set_clock(drive, p);
  }
};

Result<InsFitness> InsFitness::make(const TuningDrive& drive, const InsFitnessOptions& options) {
  WAYFARE_EXPECTS(static_cast<bool>(drive.truth), "a tuning drive needs a truth");
  auto content = std::make_shared<Content>(drive, options);
  if (content->layout.steps.empty() || content->layout.satellites.empty())
    return Error{ErrorCode::invalid, "there are no readings or no ranges after the start"};
  if (content->layout.truths.empty())
    return Error{ErrorCode::invalid, "the reference does not overlap the recording"};
  const auto chosen =
      std::find_if(std::begin(kVariants), std::end(kVariants), [&options](const Variant& v) {
        return runs_here(v.isa) && (options.kernel.empty() || options.kernel == v.name);
      });
  if (chosen == std::end(kVariants))
    return Error{ErrorCode::unsupported, "no kernel '" + options.kernel + "' on this processor"};
  content->name = chosen->name;
  content->kernel = kernel::kernel_for(chosen->isa);
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
int InsFitness::lanes() const { return content_->kernel.lanes; }
double InsFitness::length_s() const {
  double sum = 0.0;
  for (const auto& s : content_->layout.steps) sum += s.dt_s;
  return sum;
}
std::size_t InsFitness::steps() const { return content_->layout.steps.size(); }

}  // namespace wayfare
