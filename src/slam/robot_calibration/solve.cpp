#include "slam/robot_calibration/solve.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <type_traits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/motion/differential_drive_model.hpp>

namespace wayfare::calibration {
namespace {

/// Standard deviations of the vague prior, about the start: wide beside any limit.
struct Vague {
  static constexpr double kWheelScale = 0.3, kPosition_m = 1.0, kYaw_rad = 0.5, kDelay_s = 0.5;
  static constexpr double kGyroScale = 0.3, kGyroBias_rad_s = 0.1;
};

template <int N>
Eigen::Matrix<double, N, N> information(const Eigen::Matrix<double, N, 1>& sigma) {
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

/// Noise of each group of edges relative to what is expected, as a factor of its covariance.
struct Noise {
  double laser = 1.0, radar = 1.0, gyro = 1.0;
};

class Calibrator {
 public:
  Calibrator(const Problem& problem, const RobotCalibrationOptions& options)
      : p_(problem), o_(options), values_(problem.start) {}

  Result<Solution> run() {
    // Speeds by coarse Doppler bins are biased: where there is a laser, radar sizes no wheels.
    const bool later = p_.laser && p_.radar;
    if (auto done = fit(!later); !done) return done.error();
    if (later) {
      wheels_known_ = true;
      if (auto done = fit(true); !done) return done.error();
    }
    Solution solution;
    solution.values = values_;
    solution.covariance = covariance();
    solution.sensors = sensors();
    return solution;
  }

 private:
  Result<void> fit(bool with_radar) {
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      build(with_radar);
      GraphOptimiser<Graph> optimiser;
      OptimiseOptions how;
      how.method = OptimiseMethod::levenberg_marquardt;
      if (auto done = optimiser.optimise(graph_, how); !done) return done.error();
      take_values();
      rescale();
    }
    return {};
  }

  // --- the graph ---

  [[nodiscard]] RobustKernel kernel() const { return {RobustKernelKind::cauchy, o_.kernel_sigmas}; }
  /// Covariance of the base's motion by its wheels: of random slip.
  [[nodiscard]] Eigen::Matrix3d slip(double from_s, double to_s) const {
    if (!p_.base.by_wheels()) return Eigen::Matrix3d::Zero();
    const DifferentialDriveModel model{.wheel_base_m = values_.wheels[2],
                                       .slip_m_per_sqrt_m = o_.slip_m_per_sqrt_m};
    Eigen::Vector2d rolled = Eigen::Vector2d::Zero();
    for (const BaseStep& s : p_.base.steps()) {
      const double dt = std::min(s.end_s, to_s) - std::max(s.begin_s, from_s);
      if (dt > 0.0) rolled += dt * s.rates.head<2>().cwiseAbs();
      if (s.begin_s > to_s) break;
    }
    return model(rolled[0], rolled[1]).covariance;
  }
  /// Known motion, also where the delay is a little different.
  [[nodiscard]] bool covered(double from_s, double to_s, double delay_s) const {
    constexpr double kMargin_s = 0.1;
    return p_.base.covers(from_s - delay_s - kMargin_s, to_s - delay_s + kMargin_s);
  }

  void build(bool with_radar) {
    graph_ = Graph();
    wheels_ = graph_.add(values_.wheels);
    laser_ = graph_.add(values_.laser), radar_ = graph_.add(values_.radar);
    laser_delay_ = graph_.add(Delay(values_.laser_delay_s));
    radar_delay_ = graph_.add(Delay(values_.radar_delay_s));
    gyro_ = graph_.add(values_.gyro);
    gyro_delay_ = graph_.add(Delay(values_.gyro_delay_s));
    add_priors();
    if (p_.laser) add_laser();
    if (p_.radar && with_radar) add_radar();
    if (wheels_known_) graph_.fix(wheels_);
    if (p_.gyro) add_gyro();
  }
  void add_priors() {
    const Values& s = p_.start;
    using V = Vague;
    graph_.add(Prior<Wheels>{s.wheels, information<3>({V::kWheelScale, V::kWheelScale,
                                                       V::kWheelScale * s.wheels[2]})},
               wheels_);
    const Eigen::Vector3d mounting(V::kPosition_m, V::kPosition_m, V::kYaw_rad);
    graph_.add(Prior<SE2d>{s.laser, information<3>(mounting)}, laser_);
    graph_.add(Prior<SE2d>{s.radar, information<3>(mounting)}, radar_);
    const auto delay = information<1>(Delay(V::kDelay_s));
    graph_.add(Prior<Delay>{Delay(s.laser_delay_s), delay}, laser_delay_);
    graph_.add(Prior<Delay>{Delay(s.radar_delay_s), delay}, radar_delay_);
    graph_.add(Prior<Delay>{Delay(s.gyro_delay_s), delay}, gyro_delay_);
    graph_.add(Prior<GyroErrors>{s.gyro, information<2>({V::kGyroScale, V::kGyroBias_rad_s})},
               gyro_);
  }
  void add_laser() {
    for (const LaserMotion& m : p_.measured->laser.coarse) {
      if (!covered(m.from_s, m.to_s, values_.laser_delay_s)) continue;
      const Eigen::Matrix3d ad = values_.laser.inverse().adjoint();
      const Eigen::Matrix3d slipped = ad * slip(m.from_s, m.to_s) * ad.transpose();
      const Eigen::Matrix3d cov = noise_.laser * (m.covariance + slipped);
      graph_.add(
          Robust<LaserEdge>{{&p_.base, m.from_s, m.to_s, m.T_from_to, cov.inverse()}, kernel()},
          wheels_, laser_, laser_delay_);
    }
  }
  void add_radar() {
    for (const RadarMotion& m : p_.measured->radar) {
      if (!covered(m.from_s, m.to_s, values_.radar_delay_s)) continue;
      const double rate = 1.0 / (m.to_s - m.from_s);
      const Eigen::Matrix2d slipped =
          rate * rate * slip(m.from_s, m.to_s)(0, 0) * Eigen::Matrix2d::Identity();
      const Eigen::Matrix2d cov = noise_.radar * (m.covariance + slipped);
      graph_.add(
          Robust<RadarEdge>{{&p_.base, m.from_s, m.to_s, m.velocity_m_s, cov.inverse()}, kernel()},
          wheels_, radar_, radar_delay_);
    }
  }
  void add_gyro() {
    constexpr double kWalk = 0.002;  // rad/√s
    for (const GyroTurned& g : p_.measured->gyro) {
      if (!covered(g.from_s, g.to_s, values_.gyro_delay_s)) continue;
      const double variance =
          noise_.gyro * (kWalk * kWalk * (g.to_s - g.from_s) + slip(g.from_s, g.to_s)(2, 2));
      graph_.add(Robust<GyroEdge>{{&p_.base, g.from_s, g.to_s, g.turn_rad,
                                   Eigen::Matrix<double, 1, 1>(1.0 / variance)},
                                  kernel()},
                 wheels_, gyro_, gyro_delay_);
    }
  }
  void take_values() {
    values_ = {graph_[wheels_],       graph_[laser_],          graph_[radar_],
               graph_[gyro_],         graph_[laser_delay_][0], graph_[radar_delay_][0],
               graph_[gyro_delay_][0]};
  }

  // --- noise ---

  template <class E>
  [[nodiscard]] std::vector<double> squares() const {
    std::vector<double> all;
    graph_.each_edge([&](const auto& edge, const auto&, const auto&... x) {
      if constexpr (std::is_same_v<std::decay_t<decltype(edge)>, E>)
        all.push_back(squared_error(edge, x...));
    });
    return all;
  }
  /// By the median, so that outliers have no part.
  template <class E>
  void rescale(double& noise) {
    const auto all = squares<E>();
    if (all.size() < 10) return;
    noise *= std::max(median_of(all) / chi_square_quantile(0.5, E::kDim), 1e-4);
  }
  void rescale() {
    rescale<Robust<LaserEdge>>(noise_.laser);
    rescale<Robust<RadarEdge>>(noise_.radar);
    rescale<Robust<GyroEdge>>(noise_.gyro);
  }
  template <class E>
  void count(const char* name, double noise, std::vector<CalibratedSensor>& all) const {
    const auto s = squares<E>();
    if (s.empty()) return;
    const double limit = chi_square_quantile(0.9973, E::kDim);
    all.push_back(
        {name, s.size(),
         static_cast<std::size_t>(std::ranges::count_if(s, [&](double x) { return x > limit; })),
         std::sqrt(noise)});
  }
  [[nodiscard]] std::vector<CalibratedSensor> sensors() const {
    std::vector<CalibratedSensor> all;
    count<Robust<LaserEdge>>("laser", noise_.laser, all);
    count<Robust<RadarEdge>>("radar", noise_.radar, all);
    count<Robust<GyroEdge>>("gyro", noise_.gyro, all);
    return all;
  }

  // --- covariance ---

  [[nodiscard]] Eigen::Index row_of(int variable) const {
    if (variable == wheels_.index) return kWheels;
    if (variable == laser_.index) return kLaser;
    if (variable == radar_.index) return kRadar;
    if (variable == laser_delay_.index) return kLaserDelay;
    if (variable == radar_delay_.index) return kRadarDelay;
    return variable == gyro_.index ? Eigen::Index{kGyro} : Eigen::Index{kGyroDelay};
  }
  /// H⁻¹, and H⁻¹ (Σ_b g_b g_bᵀ) H⁻¹ with the gradients g_b of blocks of time, whichever has the
  /// larger variance in the direction where they differ most: row by row.
  [[nodiscard]] Joint covariance() const {
    Joint h = Joint::Zero();
    std::map<int, Eigen::Matrix<double, kRows, 1>> blocks;
    graph_.each_edge([&](const auto& edge, const auto& variables, const auto&... x) {
      using E = std::decay_t<decltype(edge)>;
      JacobiansOf<E> by;
      const EdgeError<E> e = linearise(edge, by, x...);
      const double w = robust_value(edge, e.dot(edge.information * e)).weight;
      Eigen::Matrix<double, E::kDim, kRows> j = Eigen::Matrix<double, E::kDim, kRows>::Zero();
      std::apply(
          [&](const auto&... block) {
            std::size_t i = 0;
            ((j.middleCols(row_of(variables[i++]), block.cols()) = block), ...);
          },
          by.by);
      if constexpr (std::is_same_v<E, Robust<RadarEdge>>)
        if (wheels_known_) j.template middleCols<3>(kWheels).setZero();
      h += w * j.transpose() * edge.information * j;
      if constexpr (requires { edge.from_s; }) {
        const auto block = static_cast<int>(0.5 * (edge.from_s + edge.to_s) / o_.block_s);
        using Gradient = Eigen::Matrix<double, kRows, 1>;
        auto& sum = blocks.try_emplace(block, Gradient::Zero()).first->second;
        sum += w * j.transpose() * edge.information * e;
      }
    });
    const Joint inverse = h.ldlt().solve(Joint::Identity());
    Joint meat = Joint::Zero();
    for (const auto& [index, g] : blocks) meat += g * g.transpose();
    const Joint clustered = inverse * meat * inverse;
    // Errors with common causes widen the covariance, and never narrow it.
    Eigen::Matrix<double, kRows, 1> widen;
    for (Eigen::Index i = 0; i < kRows; ++i)
      widen[i] = std::sqrt(std::max(1.0, clustered(i, i) / inverse(i, i)));
    Joint all = widen.asDiagonal() * inverse * widen.asDiagonal();
    add_radar_bias(all);
    return all;
  }

  /// Errors of the radar's velocity that no residual shows. Detectors prefer echoes beside strong
  /// ones, so that speeds rounded to bins of Δ bias the part across the line of sight by about Δ²/v
  /// (benchmarks/reports/2026-11-25_calibrate_robot.md). And speeds other than those of wheels that
  /// the laser calibrated are biased at least by the difference.
  void add_radar_bias(Joint& covariance) const {
    if (!p_.radar) return;
    constexpr double kMoves_m_s = 0.05, kTurns_rad_s = 0.1, kAcceleration_m_s2 = 1.0;
    double v2 = 0.0, w2 = 0.0, nv = 0.0, nw = 0.0;
    for (const RadarMotion& m : p_.measured->radar) {
      const double v = m.velocity_m_s.norm();
      if (v > kMoves_m_s) v2 += v * v, nv += 1.0;
      const double middle = 0.5 * (m.from_s + m.to_s) - values_.radar_delay_s;
      if (!p_.base.covers(middle, middle)) continue;
      const double w = std::abs(p_.base.twist_at(middle, values_.wheels).z());
      if (w > kTurns_rad_s) w2 += w * w, nw += 1.0;
    }
    if (nv == 0.0) return;
    const double speed = std::sqrt(v2 / nv), bin = p_.measured->doppler_step_m_s;
    double bias = bin * bin / speed;
    if (wheels_known_) {
      const MountingStart ratio = start_at(p_.base, velocities_of(p_.measured->radar),
                                           values_.wheels, values_.radar_delay_s);
      bias = std::max(bias, speed * std::abs(ratio.speed_ratio - 1.0));
    }
    const auto add = [&](Eigen::Index row, double sigma) { covariance(row, row) += sigma * sigma; };
    add(kRadar + 2, bias / speed);
    add(kRadarDelay, bias / kAcceleration_m_s2);
    if (nw == 0.0) return;
    add(kRadar, bias / std::sqrt(w2 / nw)), add(kRadar + 1, bias / std::sqrt(w2 / nw));
    if (wheels_known_ || !p_.base.by_wheels()) return;
    add(kWheels, bias / speed), add(kWheels + 1, bias / speed);
    add(kWheels + 2, values_.wheels[2] * bias / speed);
  }

  const Problem& p_;
  const RobotCalibrationOptions& o_;
  bool wheels_known_ = false;  // by the laser
  Values values_;
  Noise noise_;
  Graph graph_;
  VariableId<Wheels> wheels_;
  VariableId<SE2d> laser_, radar_;
  VariableId<Delay> laser_delay_, radar_delay_, gyro_delay_;
  VariableId<GyroErrors> gyro_;
};

}  // namespace

Result<Solution> solve(const Problem& problem, const RobotCalibrationOptions& options) {
  return Calibrator(problem, options).run();
}

}  // namespace wayfare::calibration
