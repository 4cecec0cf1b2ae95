// Local matching from the same prior on the same occupancy table of 5 cm with the same points; the
// final cost is shown.

#include <cmath>
#include <vector>

#include <benchmark/benchmark.h>
#include <Eigen/Cholesky>

#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/match/registration.hpp>

#ifdef WAYFARE_BENCH_HAS_CERES
#include <ceres/ceres.h>
#include <ceres/cubic_interpolation.h>
#endif

#include "scene.hpp"

namespace wayfare {
namespace {

struct LocalMatch {
  ProbabilityPyramid table;
  SurfaceMap surface = *SurfaceMap::make(scene().placed);
  NdtMap ndt = *NdtMap::make(scene().placed);
  SE2d start = scene().poses[20].plus({0.06, -0.05, 0.02});

  LocalMatch() {
    OccupancyGrid grid;
    ScanRaster raster;
    for (std::size_t i = 0; i < 20; ++i)
      (void)insert_scan(grid, scene().poses[i], scene().scans[i], {}, raster);
    (void)table.emplace_back().make(grid, 0.1, 8);
  }
};

const LocalMatch& problem() {
  static const LocalMatch made;
  return made;
}

constexpr int kIterations = 12;
const SearchWindow kWindow{1, 1, Angle::degrees(30)};

/// √(Σr²/N) of a pose by the library's kernel, the same for all.
double left_over(const SE2d& pose, Interpolation interpolation) {
  const GaussNewtonMatcher still({.interpolation = interpolation, .max_iterations = 0});
  return 1 - (*still.match(problem().table, scene().seen, pose, kWindow))->score;
}

void ours(benchmark::State& state, Interpolation interpolation) {
  const GaussNewtonMatcher matcher({.interpolation = interpolation, .max_iterations = kIterations});
  SE2d pose;
  for (auto _ : state)
    pose = (*matcher.match(problem().table, scene().seen, problem().start, kWindow))->T_map_points;
  state.counters["left"] = left_over(pose, interpolation);
}
BENCHMARK_CAPTURE(ours, bilinear, Interpolation::bilinear)
    ->Name("climb_bilinear/wayfare")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(ours, bicubic, Interpolation::bicubic)
    ->Name("climb_bicubic/wayfare")
    ->Unit(benchmark::kMicrosecond);

/// Plain least squares: point by point in double, bounds checked, with the same damping.
class Plain {
 public:
  struct Sums {
    double squares = 0;
    Eigen::Vector3d negative_gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  };

  explicit Plain(const ProbabilityGrid& table) : table_(table), width_(table.width()) {
    for (int y = 0; y < table.height(); ++y)
      for (int x = 0; x < table.width(); ++x)
        p_.push_back(static_cast<float>(table.probability(table.origin() + Cell{x, y})));
  }

  [[nodiscard]] Sums at(const PointSet& points, const SE2d& pose) const {
    Sums sums;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d p = points[i].cast<double>();
      const auto [value, slope] = sample(pose * p);
      const Eigen::Vector2d g = pose.rotation().inverse() * slope;
      const Eigen::Vector3d j(g.x(), g.y(), p.x() * g.y() - p.y() * g.x());
      sums.squares += (1 - value) * (1 - value);
      sums.negative_gradient += (1 - value) * j;
      sums.hessian += j * j.transpose();
    }
    return sums;
  }

  [[nodiscard]] SE2d minimise(const PointSet& points, SE2d pose) const {
    Sums here = at(points, pose);
    double damping = 1e-4;
    for (int i = 0; i < kIterations; ++i) {
      Eigen::Matrix3d damped = here.hessian;
      damped.diagonal() *= 1 + damping;
      const Eigen::Vector3d step = damped.ldlt().solve(here.negative_gradient);
      const SE2d next = pose.plus(step);
      const Sums there = at(points, next);
      if (there.squares < here.squares) {
        pose = next;
        here = there;
        damping *= 0.1;
      } else {
        damping *= 10;
      }
      if (step.norm() < 1e-4) break;
    }
    return pose;
  }

 private:
  [[nodiscard]] double cell(int x, int y) const {
    if (x < 0 || y < 0 || x >= width_ || y >= table_.height()) return 0.1;
    return static_cast<double>(p_[static_cast<std::size_t>(y * width_ + x)]);
  }
  [[nodiscard]] std::pair<double, Eigen::Vector2d> sample(const Eigen::Vector2d& p) const {
    const double u = p.x() / table_.resolution_m() - table_.origin().x - 0.5;
    const double v = p.y() / table_.resolution_m() - table_.origin().y - 0.5;
    const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
    const double a = u - x, b = v - y;
    const double p00 = cell(x, y), p10 = cell(x + 1, y), p01 = cell(x, y + 1),
                 p11 = cell(x + 1, y + 1);
    const Eigen::Vector2d slope((1 - b) * (p10 - p00) + b * (p11 - p01),
                                (1 - a) * (p01 - p00) + a * (p11 - p10));
    return {(1 - b) * ((1 - a) * p00 + a * p10) + b * ((1 - a) * p01 + a * p11),
            slope / table_.resolution_m()};
  }

  const ProbabilityGrid& table_;
  int width_;
  std::vector<float> p_;
};

void BM_Plain(benchmark::State& state) {
  const Plain plain(problem().table[0]);
  SE2d pose;
  for (auto _ : state) pose = plain.minimise(scene().seen, problem().start);
  state.counters["left"] = left_over(pose, Interpolation::bilinear);
}
BENCHMARK(BM_Plain)->Name("climb_bilinear/plain_gauss_newton")->Unit(benchmark::kMicrosecond);

void BM_Icp(benchmark::State& state) {
  const IcpMatcher matcher;
  for (auto _ : state)
    benchmark::DoNotOptimize(
        matcher.match(problem().surface, scene().seen, problem().start, kWindow));
}
BENCHMARK(BM_Icp)->Name("climb_points/wayfare_icp")->Unit(benchmark::kMicrosecond);

void BM_Ndt(benchmark::State& state) {
  const NdtMatcher matcher;
  for (auto _ : state)
    benchmark::DoNotOptimize(matcher.match(problem().ndt, scene().seen, problem().start, kWindow));
}
BENCHMARK(BM_Ndt)->Name("climb_points/wayfare_ndt")->Unit(benchmark::kMicrosecond);

#ifdef WAYFARE_BENCH_HAS_CERES
/// The table as Ceres' interpolator reads it.
struct CeresTable {
  enum { DATA_DIMENSION = 1 };
  const ProbabilityGrid& table;
  void GetValue(int row, int column, double* f) const {
    *f = table.probability(table.origin() + Cell{column, row});
  }
};

struct CeresCost {
  const ProbabilityGrid& table;
  const ceres::BiCubicInterpolator<CeresTable>& field;
  const PointSet& points;

  template <class T>
  bool operator()(const T* pose, T* residuals) const {
    const T c = cos(pose[2]), s = sin(pose[2]);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double x = static_cast<double>(points.x_m()[i]),
                   y = static_cast<double>(points.y_m()[i]);
      const T u = (pose[0] + c * x - s * y) / table.resolution_m() - double(table.origin().x) - 0.5;
      const T v = (pose[1] + s * x + c * y) / table.resolution_m() - double(table.origin().y) - 0.5;
      T p;
      field.Evaluate(v, u, &p);
      residuals[i] = 1.0 - p;
    }
    return true;
  }
};

void BM_Ceres(benchmark::State& state) {
  const CeresTable table{problem().table[0]};
  const ceres::BiCubicInterpolator<CeresTable> field(table);
  const SE2d& start = problem().start;
  double pose[3] = {};
  for (auto _ : state) {
    pose[0] = start.x();
    pose[1] = start.y();
    pose[2] = start.heading().radians();
    ceres::Problem p;
    p.AddResidualBlock(
        new ceres::AutoDiffCostFunction<CeresCost, ceres::DYNAMIC, 3>(
            new CeresCost{table.table, field, scene().seen}, static_cast<int>(scene().seen.size())),
        nullptr, pose);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.use_nonmonotonic_steps = false;
    options.max_num_iterations = kIterations;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &p, &summary);
  }
  state.counters["left"] =
      left_over(SE2d(pose[0], pose[1], Angle::radians(pose[2])), Interpolation::bicubic);
}
BENCHMARK(BM_Ceres)->Name("climb_bicubic/ceres")->Unit(benchmark::kMicrosecond);
#endif

}  // namespace
}  // namespace wayfare
