#include <wayfare/io/g2o.hpp>

#include <cmath>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "io/text/g2o_fields.hpp"
#include "io/text/g2o_lines.hpp"
#include "io/text/lines.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

/// Reads the lines of one file up to the first fault.
template <class G>
class G2oReader : G2oFields {
 public:
  using Kind = Dialect<G>;
  using Point = typename LandmarkPosition<G>::Point;

  using G2oFields::G2oFields;

  Result<AnyGraphFile> read(std::string_view all) {
    text::Lines lines(all);
    for (std::string_view line; lines.next(line);) {
      line_ = lines.number();
      const Result<void> done = take_line(line);
      if (!done) return done.error();
    }
    const Result<void> ids_known = check_ids();
    if (!ids_known) return ids_known.error();
    graph_.projected_edges = projected_;
    return AnyGraphFile(std::move(graph_));
  }

 private:
  Result<void> take_line(std::string_view line) {
    Tokens tokens(line);
    const std::string_view tag = tokens.next();
    if (tag.empty() || tag[0] == '#') return {};
    if (tag == "FIX") return take_fix(tokens);
    if (has_lines<G>(tag)) return take_known_line(tag, tokens);
    constexpr bool kPlanar = std::is_same_v<G, SE2d>;
    if (has_lines<std::conditional_t<kPlanar, SE3d, SE2d>>(tag)) {
      return fault(std::string(tag) + " in a " + (kPlanar ? "planar" : "spatial") +
                   " graph: planar and spatial lines do not mix");
    }
    for (const char c : tag)
      if (c <= 0x20 || c > 0x7e) return fault("unreadable bytes where a line's kind is expected");
    ++graph_.ignored[text::printable(tag)];
    return {};
  }

  Result<void> take_known_line(std::string_view tag, Tokens& tokens) {
    if (tag == Kind::kVertex || tag == "VERTEX2") return take_vertex(tokens);
    if (tag == Kind::kLandmark) return take_landmark(tokens);
    if (tag == Kind::kEdge) return take_edge(tokens, Triangle::rows);
    if (tag == "EDGE2") return take_edge(tokens, Triangle::toro);
    if (tag == Kind::kSensor) return take_sensor(tokens);
    if constexpr (std::is_same_v<G, SE2d>) {
      if (tag == "ODOMETRY") return take_odometry(tokens);
      if (tag == "LANDMARK") return take_sighting(tokens);
      if (tag == "BR") return take_bearing_and_range(tokens);
    }
    Result<void> done;
    const auto take = [&]<class E>(std::vector<GraphMeasurement<E>>& list) {
      if (tag == LineOf<E>::kTag) done = take_measurement(tokens, list);
    };
    std::apply([&](auto&... list) { (take(list), ...); }, graph_.measurements);
    return done;
  }

  Result<void> define(std::int64_t id, bool landmark, std::size_t index) {
    if (!places_.emplace(id, Place{landmark, index}).second)
      return fault("vertex " + std::to_string(id) + " is defined twice");
    return {};
  }

  Result<void> add_vertex(std::int64_t id, const G& pose) {
    if (!pose.translation().allFinite())
      return fault("vertex " + std::to_string(id) + ": the odometry's sum is not finite");
    if (auto done = define(id, false, graph_.vertices.size()); !done) return done;
    graph_.vertices.push_back({id, pose, line_});
    return {};
  }

  Result<void> add_landmark(std::int64_t id, const Point& position) {
    if (!position.allFinite())
      return fault("landmark " + std::to_string(id) + ": its position is not finite");
    if (auto done = define(id, true, graph_.landmarks.size()); !done) return done;
    graph_.landmarks.push_back({id, position, line_});
    return {};
  }

  Result<void> take_vertex(Tokens& tokens) {
    std::int64_t vertex = 0;
    if (auto done = id(tokens, vertex); !done) return done;
    const Result<G> value = pose<G>(tokens, "vertex pose", true);
    return value ? add_vertex(vertex, *value) : value.error();
  }

  Result<void> take_landmark(Tokens& tokens) {
    std::int64_t landmark = 0;
    if (auto done = id(tokens, landmark); !done) return done;
    Point position = Point::Zero();
    auto done = numbers(tokens, position.data(), Point::SizeAtCompileTime, "landmark", true);
    return done ? add_landmark(landmark, position) : done;
  }

  Result<void> take_sensor(Tokens& tokens) {
    std::int64_t sensor = 0;
    if (auto done = id(tokens, sensor, "parameter"); !done) return done;
    const Result<G> value = pose<G>(tokens, "sensor pose", true);
    if (!value) return value.error();
    if (!graph_.sensors.emplace(sensor, *value).second)
      return fault("parameter " + std::to_string(sensor) + " is defined twice");
    return {};
  }

  Result<void> take_fix(Tokens& tokens) {
    while (!tokens.at_end()) {
      std::int64_t value = 0;
      Result<void> done = id(tokens, value);
      if (!done) return done;
      graph_.fixed.push_back(value);
      fix_lines_.push_back(line_);
    }
    return {};
  }

  /// The ends and the measurement of an edge between poses.
  Result<GraphEdge<G>> edge_of(Tokens& tokens) const {
    std::array<std::int64_t, 2> ends{};
    if (auto done = ids(tokens, ends); !done) return done.error();
    const Result<G> value = pose<G>(tokens, "edge measurement", false);
    if (!value) return value.error();
    return GraphEdge<G>{ends[0], ends[1], *value, SquareOf<G>::Identity(), line_};
  }

  Result<void> take_edge(Tokens& tokens, Triangle order) {
    Result<GraphEdge<G>> edge = edge_of(tokens);
    if (!edge) return edge.error();
    const auto done =
        information(tokens, name_of(std::array{edge->from, edge->to}), edge->information, order);
    if (done) graph_.edges.push_back(std::move(*edge));
    return done;
  }

  template <class E>
  Result<void> take_measurement(Tokens& tokens, std::vector<GraphMeasurement<E>>& list) {
    using Line = LineOf<E>;
    GraphMeasurement<E> m;
    m.line = line_;
    Result<void> done = ids(tokens, m.ids);
    if (done && Line::kSensor) done = id(tokens, m.sensor, "parameter");
    double v[Line::kNumbers] = {};
    const std::string name = name_of(m.ids);
    if (done) done = numbers(tokens, v, Line::kNumbers, name + ": measurement", false);
    if (!done) return done;
    if (!Line::take(m.edge, v)) return fault(name + ": " + Line::kFault);
    Square<Line::kDim> omega = Square<Line::kDim>::Zero();
    done = information(tokens, name, omega, Triangle::rows);
    if (!done) return done;
    m.edge.information.template topLeftCorner<Line::kDim, Line::kDim>() = omega;
    list.push_back(std::move(m));
    return {};
  }

  // The lines of landmark logs. ------------------------------------------------------------------

  Result<void> take_odometry(Tokens& tokens) {
    Result<GraphEdge<G>> edge = edge_of(tokens);
    if (!edge) return edge.error();
    const std::array ends{edge->from, edge->to};
    auto done = log_information(tokens, name_of(ends), edge->information);
    if (done) done = find_or_place_first(ends);
    if (!done) return done;
    if (!places_.contains(edge->to))
      done = add_vertex(edge->to, pose_of_vertex(edge->from) * edge->measurement);
    if (done) graph_.edges.push_back(std::move(*edge));
    return done;
  }

  Result<void> take_sighting(Tokens& tokens) {
    GraphMeasurement<LandmarkPosition<G>> m;
    auto done = log_ends(tokens, m);
    const std::string name = name_of(m.ids);
    if (done) done = numbers(tokens, m.edge.measurement.data(), 2, name + ": measurement", false);
    if (done) done = log_information(tokens, name, m.edge.information);
    return done ? add_sighting(m, m.edge.measurement) : done;
  }

  /// A bearing and a range, independent of each other, with their standard deviations.
  Result<void> take_bearing_and_range(Tokens& tokens) {
    GraphMeasurement<BearingRange> bearing;
    double v[4] = {};
    auto done = log_ends(tokens, bearing);
    const std::string name = name_of(bearing.ids);
    if (done) done = numbers(tokens, v, 4, name + ": bearing and range", true);
    if (!done) return done;
    const double weights[] = {1.0 / (v[2] * v[2]), 1.0 / (v[3] * v[3])};
    if (v[1] < 0.0) return fault(name + ": the distance is negative");
    if (!(v[2] > 0.0 && v[3] > 0.0 && std::isfinite(weights[0] + weights[1])))
      return fault(name + ": its standard deviations are not positive");
    bearing.edge.bearing = Angle::radians(v[0]);
    bearing.edge.information = Eigen::Vector2d(weights[0], 0.0).asDiagonal();
    GraphMeasurement<RangeTo<G>> range{bearing.ids, {v[1]}, 0, line_};
    range.edge.information << weights[1];
    done = add_sighting(bearing, Point(v[1] * std::cos(v[0]), v[1] * std::sin(v[0])));
    if (done) graph_.template all<RangeTo<G>>().push_back(std::move(range));
    return done;
  }

  template <class E>
  Result<void> log_ends(Tokens& tokens, GraphMeasurement<E>& m) {
    m.line = line_;
    const auto done = ids(tokens, m.ids);
    return done ? find_or_place_first(m.ids) : done;
  }

  template <class E>
  Result<void> add_sighting(const GraphMeasurement<E>& m, const Point& seen) {
    Result<void> done;
    if (!places_.contains(m.ids[1])) done = add_landmark(m.ids[1], pose_of_vertex(m.ids[0]) * seen);
    if (done) graph_.template all<E>().push_back(m);
    return done;
  }

  const G& pose_of_vertex(std::int64_t id) const {
    return graph_.vertices[places_.at(id).index].pose;
  }

  /// The first pose of a log is the origin.
  Result<void> find_or_place_first(const std::array<std::int64_t, 2>& ends) {
    if (graph_.vertices.empty() && !places_.contains(ends[0]))
      return add_vertex(ends[0], G::identity());
    return check_id(ends, ends[0], false);
  }

  /// An edge may precede its vertices, so ids are checked at the end.
  Result<void> check_ids() {
    line_ = 0;
    if (graph_.vertices.empty()) return fault("no vertex in the file");
    for (const GraphEdge<G>& edge : graph_.edges) {
      line_ = edge.line;
      const std::array<std::int64_t, 2> ends{edge.from, edge.to};
      for (const std::int64_t end : ends)
        if (auto done = check_id(ends, end, false); !done) return done;
    }
    Result<void> done;
    const auto check = [&](const auto& list) {
      for (const auto& m : list)
        if (done) done = check_measurement(m);
    };
    std::apply([&](const auto&... list) { (check(list), ...); }, graph_.measurements);
    if (!done) return done;
    for (std::size_t i = 0; i < graph_.fixed.size(); ++i) {
      line_ = fix_lines_[i];
      if (!places_.contains(graph_.fixed[i]))
        return fault("FIX: no vertex " + std::to_string(graph_.fixed[i]));
    }
    return {};
  }

  template <class E>
  Result<void> check_measurement(const GraphMeasurement<E>& m) {
    line_ = m.line;
    constexpr bool kFirstIsLandmark = std::is_same_v<E, Prior<Point>>;
    if (auto done = check_id(m.ids, m.ids[0], kFirstIsLandmark); !done) return done;
    if (m.ids.size() == 2)
      if (auto done = check_id(m.ids, m.ids.back(), true); !done) return done;
    if (LineOf<E>::kSensor && !graph_.sensors.contains(m.sensor))
      return fault(name_of(m.ids) + ": no parameter " + std::to_string(m.sensor));
    return {};
  }

  /// `id` is that of a pose, or a landmark.
  template <std::size_t N>
  Result<void> check_id(const std::array<std::int64_t, N>& ends, std::int64_t id,
                        bool landmark) const {
    const auto found = places_.find(id);
    const char* const kind = landmark ? ": no landmark " : ": no vertex ";
    if (found == places_.end()) return fault(name_of(ends) + kind + std::to_string(id));
    if (found->second.landmark != landmark)
      return fault(name_of(ends) + ": vertex " + std::to_string(id) +
                   (landmark ? " is a pose" : " is a landmark"));
    return {};
  }

  /// Among the vertices or the landmarks.
  struct Place {
    bool landmark;
    std::size_t index;
  };

  GraphFile<G> graph_;
  std::unordered_map<std::int64_t, Place> places_;
  std::vector<std::size_t> fix_lines_;
};

/// Decided by the first line of a kind that only one of them has.
bool is_spatial(std::string_view all) {
  text::Lines lines(all);
  for (std::string_view line; lines.next(line);) {
    const std::string_view tag = text::Tokens(line).next();
    if (has_lines<SE3d>(tag)) return true;
    if (has_lines<SE2d>(tag)) return false;
  }
  return false;
}

}  // namespace

Result<AnyGraphFile> parse_g2o(std::string_view all, const std::string& source,
                               const G2oOptions& options) {
  if (is_spatial(all)) return G2oReader<SE3d>(source, options).read(all);
  return G2oReader<SE2d>(source, options).read(all);
}

Result<AnyGraphFile> read_g2o(const std::string& path, const G2oOptions& options) {
  const Result<FileContent> content = read_file(path, options.file);
  if (!content) return content.error();
  // Part of a graph is another graph: damage is an error here.
  if (content->damage) return *content->damage;
  return parse_g2o(content->bytes, path, options);
}

}  // namespace wayfare::io
