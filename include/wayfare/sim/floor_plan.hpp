#pragma once

// Floor plans: walls to simulate in, read from a drawing in characters (docs/reference/formats.md),
// and their ideal map.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare::sim {

/// A straight piece of wall, metres in the plan's frame (x right, y up).
struct Segment {
  Eigen::Vector2d a_m = Eigen::Vector2d::Zero();  ///< one end
  Eigen::Vector2d b_m = Eigen::Vector2d::Zero();  ///< other end
};

/// Walls as an image: square cells, row-major, the first row on top (largest y). The origin of the
/// plan is the lower left corner of the image.
struct CellMask {
  int width = 0;                    ///< columns
  int height = 0;                   ///< rows
  double cell_m = 0.0;              ///< side of a cell
  std::vector<std::uint8_t> solid;  ///< width * height values, nonzero for wall

  /// Of a cell in `solid`; row 0 is the top one.
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  }
  /// False outside the image.
  [[nodiscard]] bool is_solid(int column, int row) const {
    return column >= 0 && column < width && row >= 0 && row < height &&
           solid[index(column, row)] != 0;
  }
};

/// Immutable; safe to read from many threads.
class FloorPlan {
 public:
  /// Errors: no segments, or one (named by its index) that is not finite, beyond 100 km or shorter
  /// than a micrometre.
  [[nodiscard]] static Result<FloorPlan> from_segments(std::vector<Segment> segments);

  /// The outlines of the solid cells, one segment per straight run. Errors: no solid cell, or sizes
  /// that do not agree.
  [[nodiscard]] static Result<FloorPlan> from_cells(const CellMask& mask);

  /// All walls.
  [[nodiscard]] std::span<const Segment> segments() const { return segments_; }
  /// Smallest x and y of the walls, m.
  [[nodiscard]] const Eigen::Vector2d& lower_corner_m() const { return lower_m_; }
  /// Largest x and y of the walls, m.
  [[nodiscard]] const Eigen::Vector2d& upper_corner_m() const { return upper_m_; }

  /// Metres from `origin_m` along the unit vector `direction` to the first wall; infinity if there
  /// is none within `max_range_m`. A ray does not pass through the joint of two walls; a wall
  /// exactly edge-on is hit only through its neighbours. Nothing is hit from or along numbers that
  /// are not finite.
  [[nodiscard]] double cast(const Eigen::Vector2d& origin_m, const Eigen::Vector2d& direction,
                            double max_range_m) const;

  /// Whether there is a wall between the two points; false where one is not finite.
  [[nodiscard]] bool blocks(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m) const;

  /// Metres to the nearest wall within `max_m`; infinity if there is none, or the point is not
  /// finite.
  [[nodiscard]] double clearance(const Eigen::Vector2d& point_m, double max_m) const;

 private:
  FloorPlan() = default;
  void build_index();
  [[nodiscard]] std::span<const std::uint32_t> cell(int column, int row) const;
  [[nodiscard]] int column_of(double x_m) const;
  [[nodiscard]] int row_of(double y_m) const;
  template <class Visit>
  void for_cells_of(const Segment& s, Visit&& visit) const;

  std::vector<Segment> segments_;
  Eigen::Vector2d lower_m_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d upper_m_ = Eigen::Vector2d::Zero();
  double cell_m_ = 1.0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::uint32_t> first_;  // cell c lists members_[first_[c] .. first_[c + 1])
  std::vector<std::uint32_t> members_;
};

/// A point outside the plan that can be reached from `inside_m` without crossing a wall; nothing if
/// the walls around `inside_m` are closed. Finds every gap wider than `step_m` (walls that meet
/// within a step may hide a narrower one).
[[nodiscard]] std::optional<Eigen::Vector2d> find_leak(const FloorPlan& plan,
                                                       const Eigen::Vector2d& inside_m,
                                                       double step_m = 0.1);

/// A plan and the waypoints of a robot in it, metres.
struct PlannedRoute {
  FloorPlan plan;                        ///< walls
  std::vector<Eigen::Vector2d> route_m;  ///< empty if the text has no route
};

/// Reads a plan: `wall`, `place`, `route` and `metres_per_character` lines, then, after a line
/// `picture`, the drawing ('#' is wall, a letter or digit is a place, ' ' and '.' are free). Errors
/// have `source` and the line, and name the column if useful.
[[nodiscard]] Result<PlannedRoute> read_plan(std::string_view text,
                                             std::string_view source = "plan");

/// Walls from a grey image (rows from the top, one byte per pixel), such as a map image: pixels
/// darker than `wall_below` are wall.
[[nodiscard]] Result<FloorPlan> plan_from_picture(std::span<const std::uint8_t> pixels, int width,
                                                  int height, double metres_per_pixel,
                                                  std::uint8_t wall_below = 100);

/// The plan of the demonstration's building, 60 m x 30 m: a loop of long, nearly featureless
/// corridors, rooms with doors, a hall with pillars, and a route of two laps.
[[nodiscard]] std::string_view demo_building();

/// Cells that a wall passes through are occupied, those that can be reached from `inside_m` without
/// crossing one are free, the rest unknown. Errors: more cells than fit in memory, or an `inside_m`
/// in a wall or outside.
[[nodiscard]] Result<OccupancyGrid> map_of_plan(const FloorPlan& plan,
                                                const Eigen::Vector2d& inside_m,
                                                const OccupancyGridOptions& options = {});

/// A planar range finder. The default resembles a SICK LMS: 180 beams over 180°.
struct Lidar2dParams {
  std::size_t beams = 180;                      ///< of a scan
  Angle first_bearing = Angle::degrees(-90.0);  ///< of beam 0
  Angle bearing_step = Angle::degrees(1.0);     ///< from beam to beam
  double min_range_m = 0.05;                    ///< nearer walls give no return
  double max_range_m = 30.0;                    ///< farther walls give no return
  double range_noise_m = 0.01;                  ///< standard deviation, the same at every distance
  double resolution_m = 0.001;   ///< ranges are rounded to multiples of it; 0: not rounded
  double missed_return = 0.002;  ///< probability of no return from a wall
  Duration sweep{0};             ///< time from the first beam to the last; 0: at one instant
};

/// A sensor with a full field of view: `beams` equal steps over 360°.
[[nodiscard]] Lidar2dParams full_circle(std::size_t beams);

/// The sweep that starts at `time`; `T_plan_laser(t)` is the laser's pose during it, which each
/// beam is measured from at its own time. A beam without return (nothing in range, or missed) reads
/// `max_range_m`.
[[nodiscard]] LaserScan simulate_scan(const FloorPlan& plan,
                                      const std::function<SE2d(LogTime)>& T_plan_laser,
                                      LogTime time, const Lidar2dParams& params, Rng& rng);

}  // namespace wayfare::sim
