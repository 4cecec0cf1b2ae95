// Compiled once for each instruction set, with WAYFARE_ISA naming its namespace.

#include <cmath>

#include <wayfare/core/pack.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/gnss/range_model.hpp>
#include <wayfare/inertial/ins_model.hpp>

#include "tune/kernels/composed_steps.hpp"
#include "tune/kernels/kernels.hpp"

namespace wayfare::fitness_kernels::WAYFARE_ISA {
namespace {

#if defined(__AVX512F__)
constexpr int kLanes = 8;
#elif defined(__AVX2__)
constexpr int kLanes = 4;
#else
constexpr int kLanes = 2;
#endif

using T = Pack<double, kLanes>;
using State = InsState<T, 0>;
using Filter = Ekf<State>;
using Vector3 = Eigen::Matrix<T, 3, 1>;

SO3d rotation(const Quaternion& q) { return SO3d(Eigen::Quaterniond(q[0], q[1], q[2], q[3])); }

/// Genes in the order of Zhang 2020, table 2: gyro bias σ τ, gyro scale σ τ, accelerometer bias σ
/// τ, accelerometer scale σ τ, white noises, clock, range scale.
class Individuals {
 public:
  explicit Individuals(const double* genes) {
    for (int g = 0; g < kGenes; ++g)
      for (int i = 0; i < kLanes; ++i) value_[g].set(i, genes[g * kLanes + i]);
  }
  [[nodiscard]] InsNoise<T> noise() const {
    constexpr int kBlocks[] = {0, 12, 6, 18};  // positions of the filter's four triples
    InsNoise<T> n;
    for (int b = 0; b < 4; ++b) {
      for (int i = 0; i < 3; ++i) {
        n.sigma[3 * b + i] = value_[kBlocks[b] + i];
        n.tau_s[3 * b + i] = value_[kBlocks[b] + 3 + i];
      }
    }
    for (int i = 0; i < 3; ++i) {
      n.gyro_white[i] = value_[24 + i];
      n.accel_white[i] = value_[27 + i];
    }
    n.clock_bias_walk = value_[30];
    n.clock_drift_walk = value_[31];
    return n;
  }
  [[nodiscard]] const T& range_scale() const { return value_[32]; }

 private:
  T value_[kGenes];
};

class Drive {
 public:
  Drive(const Problem& problem, const Individuals& individuals)
      : problem_(problem),
        noise_(individuals.noise()),
        range_scale_(individuals.range_scale()),
        lever_(problem.lever_imu_m.cast<T>()),
        imu_body_(rotation(problem.q_body_imu).inverse().cast<T>()),
        plane_(problem.anchors.front()),
        model_(plane_, noise_),
        interval_(plane_, noise_, problem.nominal_dt_s),
        filter_(start(), covariance()) {
    model_.prepare(problem.nominal_dt_s);
    for (T& s : squares_) s = T(0);
  }

  void run(bool by_intervals, double* rmse) {
    const Step* before = nullptr;
    for (const Step& s : problem_.steps) {
      if (by_intervals)
        step_of_interval(s, before == nullptr || before->ends_interval);
      else
        step(s);
      before = &s;
    }
    for (int k = 0; k < kScores; ++k) {
      const T mean = squares_[k] / T(counts_[k] > 0 ? counts_[k] : 1);
      const T score = select(is_finite(mean), sqrt(mean), T(HUGE_VAL));
      for (int i = 0; i < kLanes; ++i) rmse[k * kLanes + i] = score[i];
    }
  }

 private:
  [[nodiscard]] State start() const {
    State x;
    x.velocity_mps = problem_.start_velocity_mps.cast<T>();
    x.q_nu = (rotation(problem_.start_q_nb) * rotation(problem_.q_body_imu)).cast<T>();
    x.clock[0] = T(problem_.clock_bias_m);
    x.clock[1] = T(problem_.clock_drift_mps);
    return x;
  }
  [[nodiscard]] Filter::Square covariance() const {
    using namespace ins_state;
    Filter::Square p = Filter::Square::Constant(T(0));
    const auto square = [](double s) { return T(s * s); };
    for (int i = 0; i < 3; ++i) {
      p(kPosition + i, kPosition + i) = square(problem_.position_sigma_m);
      p(kVelocity + i, kVelocity + i) = square(problem_.velocity_sigma_mps);
    }
    const Eigen::Matrix3d c =
        (rotation(problem_.start_q_nb) * rotation(problem_.q_body_imu)).matrix();
    const double level = problem_.level_sigma_rad, heading = problem_.heading_sigma_rad;
    const Eigen::Vector3d v(level * level, level * level, heading * heading);
    p.block<3, 3>(kAttitude, kAttitude) =
        Eigen::Matrix3d(c.transpose() * v.asDiagonal() * c).cast<T>();
    for (int i = 0; i < 12; ++i)
      p(kGyroBias + i, kGyroBias + i) = noise_.sigma[i] * noise_.sigma[i];
    p(kClock, kClock) = square(problem_.clock_sigma_m);
    p(kClock + 1, kClock + 1) = square(problem_.clock_drift_sigma_mps);
    return p;
  }

  void step(const Step& s) {
    if (s.plane != at_plane_) recentre(s.plane);
    filter_.predict(model_, s.imu);
    const Vector3 vibration = vibration_variance(s);
    for (int i = 0; i < 3; ++i) filter_.add_variance(ins_state::kAttitude + i, vibration[i]);
    if (s.truth) score(filter_.state(), *s.truth);
    if (s.satellites > 0) update(s);
  }

  /// The same with one propagation of the covariance for each interval.
  void step_of_interval(const Step& s, bool begins) {
    if (begins) {
      if (s.plane != at_plane_) recentre(s.plane);
      interval_.begin(filter_.state());
    }
    interval_.add(s, vibration_variance(s));
    if (s.truth) score(interval_.state(), *s.truth);
    if (!s.ends_interval) return;
    filter_.predict([this](const State& from) { return interval_.step(from); });
    if (s.satellites > 0) update(s);
  }

  /// As in the navigation system: the aliased fraction of the vibration is an error of each
  /// reading.
  [[nodiscard]] Vector3 vibration_variance(const Step& s) const {
    const double share = problem_.vibration_share * s.imu.dt_s;
    Vector3 variance = Vector3::Constant(T(0));
    if (share == 0.0) return variance;
    for (int i = 0; i < 3; ++i) {
      const T white = noise_.gyro_white[i];
      const T more = T(s.vibration[i]) - T(2.0 / s.imu.dt_s) * white * white;
      variance[i] = T(share * share) * select(more > T(0), more, T(0));
    }
    return variance;
  }

  void update(const Step& s) {
    const Vector3 rate = s.imu.end_rate_radps.cast<T>();
    const T gate = T(problem_.gate_sigma);
    for (std::size_t k = s.first_satellite; k < s.first_satellite + s.satellites; ++k) {
      const CorrectedRange& from = problem_.satellites[k];
      const SatelliteView view(from, plane_);
      if (std::isfinite(from.range_m) && from.range_sigma_m > 0.0) {
        const T sigma = range_scale_ * T(from.range_sigma_m);
        (void)filter_.update(RangeModel<T, 0>{plane_, view, from.range_m - view.anchor_range_m,
                                              sigma * sigma, lever_},
                             gate);
      }
      if (std::isfinite(from.range_rate_mps) && from.range_rate_sigma_mps > 0.0) {
        const T sigma = range_scale_ * T(from.range_rate_sigma_mps);
        (void)filter_.update(
            RangeRateModel<T, 0>{plane_, view, from.range_rate_mps, sigma * sigma, lever_, rate},
            gate);
      }
    }
  }

  void score(const State& x, const Truth& truth) {
    for (int i = 0; i < 3; ++i) {
      const T e = x.position_m[i] - T(truth.offset_m[i]);
      squares_[i] += e * e;
      counts_[i] += 1.0;
    }
    if (!truth.has_level && !truth.has_heading) return;
    const SO3<T> error = rotation(truth.q_nb).inverse().cast<T>() * (x.q_nu * imu_body_);
    const Eigen::Matrix<T, 3, 3> r = error.matrix();
    if (truth.has_level) {
      add(3, atan2(r(2, 1), r(2, 2)));
      add(4, atan2(-r(2, 0), sqrt(r(0, 0) * r(0, 0) + r(1, 0) * r(1, 0))));
    }
    if (truth.has_heading) add(5, atan2(r(1, 0), r(0, 0)));
  }
  void add(int k, const T& e) {
    squares_[k] += e * e;
    counts_[k] += 1.0;
  }

  void recentre(std::size_t anchor) {
    const LocalTangentPlane next(problem_.anchors[anchor]);
    State x = filter_.state();
    for (int i = 0; i < kLanes; ++i) {
      Eigen::Vector3d p;
      for (int k = 0; k < 3; ++k) p[k] = x.position_m[k][i];
      const Eigen::Vector3d moved = next.offset(plane_.geodetic(p));
      for (int k = 0; k < 3; ++k) x.position_m[k].set(i, moved[k]);
    }
    filter_.set_state(x);
    plane_ = next;
    at_plane_ = anchor;
    model_ = InsModel<T, 0>(plane_, noise_);
    model_.prepare(problem_.nominal_dt_s);
  }

  const Problem& problem_;
  InsNoise<T> noise_;
  T range_scale_;
  Vector3 lever_;
  SO3<T> imu_body_;
  LocalTangentPlane plane_;
  std::size_t at_plane_ = 0;
  InsModel<T, 0> model_;
  ComposedSteps<T> interval_;
  Filter filter_;
  T squares_[kScores];
  double counts_[kScores] = {};
};

/// Shorter correlation times are not resolved by the nodes of an interval.
constexpr double kShortestTau_s = 2.0;

void evaluate(const Problem& problem, const double* genes, double* rmse) {
  const Individuals individuals(genes);
  const InsNoise<T> noise = individuals.noise();
  MaskOf<T> slow = problem.by_intervals;
  for (const T& tau : noise.tau_s) slow = slow && tau > T(kShortestTau_s);
  if (any(slow)) Drive(problem, individuals).run(true, rmse);
  if (all(slow)) return;
  double each[kScores * kLanes];
  Drive(problem, individuals).run(false, each);
  for (int k = 0; k < kScores; ++k)
    for (int i = 0; i < kLanes; ++i)
      if (!slow[i]) rmse[k * kLanes + i] = each[k * kLanes + i];
}

}  // namespace

extern const Kernel table;
const Kernel table = {kLanes, evaluate};

}  // namespace wayfare::fitness_kernels::WAYFARE_ISA
