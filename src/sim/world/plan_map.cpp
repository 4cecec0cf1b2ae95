#include <wayfare/sim/floor_plan.hpp>

#include <string>
#include <vector>

#include <wayfare/map/cell.hpp>

namespace wayfare::sim {
namespace {

constexpr std::int64_t kMaxCells = std::int64_t{1} << 26;

/// One byte per cell of a box.
class Marks {
 public:
  explicit Marks(const CellBox& box)
      : box_(box), marks_(static_cast<std::size_t>(box.width() * box.height())) {}
  [[nodiscard]] bool inside(const Cell& c) const { return box_.contains(c); }
  std::uint8_t& at(const Cell& c) {
    return marks_[static_cast<std::size_t>((std::int64_t{c.y} - box_.min.y) * box_.width() +
                                           (std::int64_t{c.x} - box_.min.x))];
  }

 private:
  CellBox box_;
  std::vector<std::uint8_t> marks_;
};

}  // namespace

Result<OccupancyGrid> map_of_plan(const FloorPlan& plan, const Eigen::Vector2d& inside_m,
                                  const OccupancyGridOptions& options) {
  OccupancyGrid grid(options);
  const double cell_m = options.resolution_m;
  const CellBox box{cell_of(plan.lower_corner_m(), cell_m) - Cell{1, 1},
                    cell_of(plan.upper_corner_m(), cell_m) + Cell{1, 1}};
  if (box.width() > kMaxCells || box.height() > kMaxCells / box.width())
    return Error{ErrorCode::invalid, "map_of_plan: " + std::to_string(box.width()) + " x " +
                                         std::to_string(box.height()) + " cells cannot be held"};
  constexpr std::uint8_t kWall = 1, kFree = 2;
  Marks marks(box);
  // A wall on the line between two cells occupies both: a sensor may detect it in either.
  const double aside_m = 1e-3 * cell_m;
  for (const Segment& s : plan.segments())
    for (const double dx : {-aside_m, aside_m})
      for (const double dy : {-aside_m, aside_m}) {
        const Eigen::Vector2d by(dx, dy);
        for_each_cell_on_segment(Eigen::Vector2d(s.a_m + by), Eigen::Vector2d(s.b_m + by), cell_m,
                                 [&](const Cell& c) {
                                   if (marks.inside(c)) marks.at(c) = kWall;
                                 });
      }
  const Cell start = cell_of(inside_m, cell_m);
  if (!marks.inside(start) || marks.at(start) == kWall)
    return Error{ErrorCode::invalid, "map_of_plan: the inside point is in a wall or outside"};
  std::vector<Cell> open{start};
  marks.at(start) = kFree;
  while (!open.empty()) {
    const Cell c = open.back();
    open.pop_back();
    for (const Cell& step : {Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}}) {
      const Cell next = c + step;
      if (!marks.inside(next) || marks.at(next) != 0) continue;
      marks.at(next) = kFree;
      open.push_back(next);
    }
  }
  const LogOdds wall = LogOdds::from_probability(options.max_probability);
  const LogOdds free = LogOdds::from_probability(options.min_probability);
  for (int y = box.min.y; y <= box.max.y; ++y)
    for (int x = box.min.x; x <= box.max.x; ++x)
      if (const std::uint8_t mark = marks.at({x, y}); mark != 0)
        grid.update({x, y}, mark == kWall ? wall : free);
  return grid;
}

}  // namespace wayfare::sim
