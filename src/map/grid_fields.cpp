// Likelihood fields of occupancy grids, of their probabilities or of detections.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <wayfare/map/detection_grid.hpp>

namespace wayfare {
namespace {

/// With a smaller σ, in cells, the neighbours' weights are zero, and soon 0/0 at the centre.
constexpr double kNoBlur = 1e-3;

std::vector<float> gaussian(double sigma_cells) {
  const int radius = static_cast<int>(std::ceil(3 * sigma_cells));
  std::vector<float> weights;
  float sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    weights.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma_cells * sigma_cells))));
    sum += weights.back();
  }
  for (float& w : weights) w /= sum;
  return weights;
}

/// Convolves a line of `n` values, `step` apart; values outside it are `outside`.
void blur_line(float* line, int n, std::ptrdiff_t step, const std::vector<float>& weights,
               float outside, std::vector<float>& copy) {
  const int radius = static_cast<int>(weights.size() / 2);
  copy.assign(static_cast<std::size_t>(n + 2 * radius), outside);
  for (int i = 0; i < n; ++i) copy[static_cast<std::size_t>(i + radius)] = line[i * step];
  for (int i = 0; i < n; ++i) {
    float sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k)
      sum += weights[k] * copy[static_cast<std::size_t>(i) + k];
    line[i * step] = sum;
  }
}

/// In place, a row-major image; `sigma_cells` above 0. Pixels beyond it have the value `outside`.
void blur(std::vector<float>& p, int width, int height, double sigma_cells, float outside) {
  const std::vector<float> weights = gaussian(sigma_cells);
  std::vector<float> copy;
  for (int y = 0; y < height; ++y)
    blur_line(p.data() + std::ptrdiff_t{y} * width, width, 1, weights, outside, copy);
  for (int x = 0; x < width; ++x) blur_line(p.data() + x, height, width, weights, outside, copy);
}

/// value_of(cell) for every cell of a box, row by row, with a Gaussian blur.
template <class ValueOf>
std::vector<float> blurred(const CellBox& box, double sigma_cells, float outside,
                           const ValueOf& value_of) {
  std::vector<float> image;
  image.reserve(static_cast<std::size_t>(box.cells()));
  for (int y = box.min.y; y <= box.max.y; ++y)
    for (int x = box.min.x; x <= box.max.x; ++x)
      image.push_back(static_cast<float>(value_of(Cell{x, y})));
  if (sigma_cells > kNoBlur)
    blur(image, static_cast<int>(box.width()), static_cast<int>(box.height()), sigma_cells,
         outside);
  return image;
}

/// Sets the values of `view` to ln_of(pixel).
template <class LnOf>
void quantise(const std::vector<float>& image, const LnOf& ln_of, LikelihoodField& view) {
  const float* pixel = image.data();
  for (int y = 0; y < view.height(); ++y) {
    std::uint16_t* row = view.data() + std::ptrdiff_t{y} * view.stride();
    for (int x = 0; x < view.width(); ++x) {
      const double ln = ln_of(static_cast<double>(*pixel++));
      const double value = std::round((ln - view.log_floor()) / view.log_step());
      row[x] = static_cast<std::uint16_t>(
          std::clamp(value, 0.0, static_cast<double>(LikelihoodField::kMaxValue)));
    }
  }
}

constexpr int kMaxRadius = 15;  // of DetectionFieldMaker's kernel, cells

Error invalid(const char* what) {
  return {ErrorCode::invalid, std::string("DetectionFieldMaker: ") + what};
}

bool usable(const DetectionViewOptions& o, double sigma_cells) {
  // At least one unit of log-odds.
  return o.max_detections >= 0.0 && std::isfinite(o.max_detections) &&
         LogOdds::from_probability(o.hit_probability).fixed > 0 && o.hit_probability < 1.0 &&
         sigma_cells >= 0.0 && o.background > 0.0 && std::isfinite(o.background);
}

/// The cells the points can reach, none if they are not finite.
std::optional<CellBox> reachable(const PointSet& points, const SE2d& pose, const FieldReach& reach,
                                 double resolution_m) {
  Eigen::Array2d low = Eigen::Array2d::Constant(1e300), high = -low;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Array2d p = pose * Eigen::Vector2d(points[i].cast<double>());
    if (!p.allFinite()) return std::nullopt;
    low = low.min(p);
    high = high.max(p);
  }
  const double margin =
      reach.translation_m + reach.heading_rad * static_cast<double>(points.max_norm_m());
  if (!((high - low).maxCoeff() + 2.0 * margin < 1e4) || !(high.abs().maxCoeff() < 1e6))
    return std::nullopt;
  const Eigen::Vector2d edge = Eigen::Vector2d::Constant(margin);
  const CellBox box{cell_of(Eigen::Vector2d(low) - edge, resolution_m),
                    cell_of(Eigen::Vector2d(high) + edge, resolution_m)};
  const CellBox named{{1 - kMaxCell, 1 - kMaxCell}, {kMaxCell - 1, kMaxCell - 1}};
  if (!named.contains(box.min) || !named.contains(box.max)) return std::nullopt;
  return box;
}

}  // namespace

Result<LikelihoodField> likelihood_field(const OccupancyGrid& grid,
                                         const OccupancyViewOptions& options) {
  const double sigma_cells = options.blur_sigma_m / grid.resolution_m();
  if (!(sigma_cells >= 0 && sigma_cells <= 100) ||
      !(options.unknown_probability >= 0 && options.unknown_probability <= 1))
    return Error{ErrorCode::invalid, "likelihood_field: blur or unknown probability out of range"};
  if (!grid.bounds())
    return Error{ErrorCode::invalid, "likelihood_field: the occupancy grid has no observed cell"};
  LikelihoodField view;
  const CellBox& box = *grid.bounds();
  if (auto ok = view.reset(grid.resolution_m(), box, options.floor_probability); !ok)
    return ok.error();
  const double unknown = options.unknown_probability;
  const auto p = blurred(box, sigma_cells, static_cast<float>(unknown), [&](const Cell& c) {
    return grid.observed(c) ? grid.probability(c) : unknown;
  });
  quantise(
      p, [](double here) { return std::log(std::max(1e-12, here)); }, view);
  return view;
}

Result<LikelihoodField> detection_grid(const OccupancyGrid& grid,
                                       const DetectionViewOptions& options) {
  const double sigma_cells = options.blur_sigma_m / grid.resolution_m();
  if (!usable(options, sigma_cells) || sigma_cells > 100.0)
    return Error{ErrorCode::invalid,
                 "detection_grid: hit probability, blur or background out of range"};
  if (!grid.bounds()) return Error{ErrorCode::invalid, "detection_grid: the map has no detections"};
  const CellBox& box = *grid.bounds();
  LikelihoodField view;
  // Fails on a map that is too large before anything of its size is allocated.
  if (auto ok = view.reset(grid.resolution_m(), box, 0.5); !ok) return ok.error();
  const double hit_nats = LogOdds::from_probability(options.hit_probability).nats();
  const auto n = blurred(box, sigma_cells, 0.0F, [&](const Cell& c) {
    return std::max(0.0, grid.log_odds(c).nats() / hit_nats);
  });
  const double most =
      (options.max_detections > 0.0 ? options.max_detections
                                    : static_cast<double>(*std::max_element(n.begin(), n.end()))) +
      options.background;
  // Cells without detections have the same value inside the map and outside.
  if (auto ok = view.reset(grid.resolution_m(), box, options.background / most); !ok)
    return ok.error();
  quantise(
      n, [&](double here) { return std::log((here + options.background) / most); }, view);
  return view;
}

void DetectionFieldMaker::prepare_kernel(double sigma_cells) {
  if (sigma_cells == sigma_cells_ && !kernel_.empty()) return;
  sigma_cells_ = sigma_cells;
  radius_ = sigma_cells > kNoBlur ? static_cast<int>(std::ceil(3.0 * sigma_cells)) : 0;
  kernel_.clear();
  float sum = 0.0F;
  for (int y = -radius_; y <= radius_; ++y)
    for (int x = -radius_; x <= radius_; ++x) {
      const double d2 = x * x + y * y;
      kernel_.push_back(radius_ > 0
                            ? static_cast<float>(std::exp(-0.5 * d2 / (sigma_cells * sigma_cells)))
                            : 1.0F);
      sum += kernel_.back();
    }
  for (float& k : kernel_) k /= sum;
}

/// Adds the kernel at every detection, including those just outside `box`.
void DetectionFieldMaker::spread(const OccupancyGrid& grid, const CellBox& box, double hit_nats) {
  const auto per_unit = static_cast<float>(1.0 / (LogOdds::kUnitsPerNat * hit_nats));
  const int width = static_cast<int>(box.width()), height = static_cast<int>(box.height());
  density_.assign(static_cast<std::size_t>(box.cells()), 0.0F);
  const int side = 2 * radius_ + 1;
  const auto add = [&](int x, int y, float n) {
    const int x0 = std::max(x - radius_, 0), x1 = std::min(x + radius_, width - 1);
    const int y0 = std::max(y - radius_, 0), y1 = std::min(y + radius_, height - 1);
    for (int v = y0; v <= y1; ++v) {
      float* row = density_.data() + std::ptrdiff_t{v} * width;
      const float* k = kernel_.data() + std::ptrdiff_t{v - y + radius_} * side - x + radius_;
      for (int u = x0; u <= x1; ++u) row[u] += n * k[u];
    }
  };
  grid.for_each_row(box.grown(radius_), [&](const Cell& first, std::span<const std::int16_t> row) {
    Cell at = first - box.min;
    for (const std::int16_t l : row) {
      if (l > 0) add(at.x, at.y, per_unit * static_cast<float>(l));
      ++at.x;
    }
  });
}

void DetectionFieldMaker::write(const DetectionViewOptions& options, LikelihoodField& view) const {
  const auto background = static_cast<float>(options.background);
  const auto per_nat = static_cast<float>(1.0 / view.log_step());
  const float* n = density_.data();
  for (int y = 0; y < view.height(); ++y) {
    std::uint16_t* row = view.data() + std::ptrdiff_t{y} * view.stride();
    for (int x = 0; x < view.width(); ++x, ++n) {
      if (*n == 0.0F) continue;
      const float value = std::log1p(*n / background) * per_nat;
      row[x] = static_cast<std::uint16_t>(
          std::min(value + 0.5F, static_cast<float>(LikelihoodField::kMaxValue)));
    }
  }
}

Result<void> DetectionFieldMaker::make(const OccupancyGrid& grid, const PointSet& points,
                                       const SE2d& T_map_points, const FieldReach& reach,
                                       const DetectionViewOptions& options, LikelihoodField& view) {
  const auto empty_with = [&](Error e) -> Result<void> {
    view = LikelihoodField();
    return e;
  };
  const double resolution = grid.resolution_m(), sigma_cells = options.blur_sigma_m / resolution;
  if (!usable(options, sigma_cells) || !(3.0 * sigma_cells <= kMaxRadius) ||
      !(options.max_detections > 0.0) || !(reach.translation_m >= 0 && reach.heading_rad >= 0))
    return empty_with(invalid("an option is out of range (the kernel may reach 15 cells)"));
  if (points.empty()) return empty_with(invalid("no points"));
  const auto box = reachable(points, T_map_points, reach, resolution);
  if (!box) return empty_with(invalid("a point or the pose is not finite or too far away"));
  const double floor = options.background / (options.max_detections + options.background);
  if (auto ok = view.reset(resolution, *box, floor); !ok) return ok;
  prepare_kernel(sigma_cells);
  spread(grid, *box, LogOdds::from_probability(options.hit_probability).nats());
  write(options, view);
  return {};
}

}  // namespace wayfare
