#include "outputs.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include <wayfare/eval/table.hpp>
#include <wayfare/graph/optimise.hpp>

namespace wayfare::examples {
namespace {

constexpr double kPanel_px = 560.0, kMargin_px = 24.0, kTitle_px = 30.0;

/// From metres to pixels of a panel.
struct Frame {
  double left = std::numeric_limits<double>::infinity(), right = -left, low = left, high = -left;

  template <class G>
  explicit Frame(const std::vector<G>& poses) {
    for (const G& x : poses) {
      left = std::min(left, x.translation()[0]), right = std::max(right, x.translation()[0]);
      low = std::min(low, x.translation()[1]), high = std::max(high, x.translation()[1]);
    }
  }
  [[nodiscard]] double scale() const {
    return (kPanel_px - 2.0 * kMargin_px) / std::max({right - left, high - low, 1e-9});
  }
  [[nodiscard]] double px(double x) const {
    return 0.5 * kPanel_px + scale() * (x - 0.5 * (left + right));
  }
  [[nodiscard]] double py(double y) const {
    return kTitle_px + 0.5 * kPanel_px - scale() * (y - 0.5 * (low + high));
  }
};

void append(std::string& out, const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  out += text;
}

template <class G>
class Panel {
 public:
  Panel(std::string& out, const PoseGraph<G>& graph)
      : out_(out), graph_(graph), frame_(graph.poses) {}

  void draw(const char* title, const std::vector<char>& rejected) {
    append(out_, "<text x=\"%.0f\" y=\"20\" text-anchor=\"middle\">%s: sum of e'We %.6g</text>\n",
           0.5 * kPanel_px, title, sum_of_errors(rejected));
    const auto is_path = [](const PoseEdge<G>& e) { return std::abs(e.from - e.to) == 1; };
    lines("loop", [&](std::size_t k) { return rejected[k] == 0 && !is_path(graph_.edges[k]); });
    lines("path", [&](std::size_t k) { return rejected[k] == 0 && is_path(graph_.edges[k]); });
    lines("false", [&](std::size_t k) { return rejected[k] != 0; });
  }

 private:
  const auto& position(int pose) const {
    return graph_.poses[static_cast<std::size_t>(pose)].translation();
  }

  double sum_of_errors(const std::vector<char>& rejected) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < rejected.size(); ++k)
      if (rejected[k] == 0) sum += squared_error(graph_, graph_.edges[k]);
    return sum;
  }

  void lines(const char* kind, auto wanted) {
    append(out_, "<path class=\"%s\" d=\"", kind);
    int last = -1;
    for (std::size_t k = 0; k < graph_.edges.size(); ++k) {
      if (!wanted(k)) continue;
      const auto& edge = graph_.edges[k];
      if (edge.from != last) point('M', edge.from);
      point('L', last = edge.to);
    }
    out_ += "\"/>\n";
  }

  void point(char command, int pose) {
    append(out_, "%c%.1f %.1f", command, frame_.px(position(pose)[0]),
           frame_.py(position(pose)[1]));
  }

  std::string& out_;
  const PoseGraph<G>& graph_;
  Frame frame_;
};

constexpr const char* kPlanar[] = {"x", "y", "theta"};
constexpr const char* kSpatial[] = {"x", "y", "z", "rx", "ry", "rz"};

/// "x_theta_m_rad", "x_x_m2".
std::string heading_of(int dof, int i, int j) {
  const auto name = [&](int k) { return std::string(dof == 3 ? kPlanar[k] : kSpatial[k]); };
  const int moves = dof == 3 ? 2 : 3;
  const char* unit = j < moves ? "m2" : i < moves ? "m_rad" : "rad2";
  return name(i) + "_" + name(j) + "_" + unit;
}

template <LieGroup G>
PoseGraph<G> without(const PoseGraph<G>& graph, const std::vector<int>& rejected) {
  PoseGraph<G> rest = graph;
  rest.edges.clear();
  std::size_t next = 0;
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    if (next < rejected.size() && rejected[next] == static_cast<int>(k)) {
      ++next;
    } else {
      rest.edges.push_back(graph.edges[k]);
    }
  }
  return rest;
}

}  // namespace

template <LieGroup G>
std::string draw(const PoseGraph<G>& graph, const std::vector<G>& before,
                 const std::vector<int>& rejected) {
  std::vector<char> is_rejected(graph.edges.size(), 0);
  for (const int k : rejected) is_rejected[static_cast<std::size_t>(k)] = 1;
  std::string out;
  append(out,
         "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" "
         "font-family=\"sans-serif\" font-size=\"14\">\n",
         2.0 * kPanel_px, kPanel_px + kTitle_px);
  out +=
      "<style>path{fill:none;stroke-linejoin:round}.path{stroke:#1f4e79;stroke-width:1}"
      ".loop{stroke:#e0a030;stroke-width:.6;stroke-opacity:.7}"
      ".false{stroke:#d02020;stroke-width:.6;stroke-opacity:.6}</style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  PoseGraph<G> start = graph;
  start.poses = before;
  Panel<G>(out, start).draw("before", is_rejected);
  append(out, "<g transform=\"translate(%.0f 0)\">\n", kPanel_px);
  Panel<G>(out, graph).draw("after", is_rejected);
  append(out, "</g>\n<text x=\"12\" y=\"%.0f\">", kPanel_px + kTitle_px - 6.0);
  out += "<tspan fill=\"#1f4e79\">path</tspan> <tspan fill=\"#c08010\">loops</tspan>";
  if (!rejected.empty()) out += " <tspan fill=\"#d02020\">rejected, not in the sum</tspan>";
  out += "</text>\n</svg>\n";
  return out;
}

template <LieGroup G>
Result<std::string> marginals_table(const PoseGraph<G>& graph, const std::vector<int>& rejected,
                                    const RobustKernel& kernel) {
  constexpr int kDof = ManifoldTraits<G>::kDof;
  PoseGraphOptimiser<G> optimiser;
  const auto covariances = optimiser.covariances(without(graph, rejected), kernel);
  if (!covariances) return covariances.error();
  std::string out = "vertex";
  for (int i = 0; i < kDof; ++i)
    for (int j = i; j < kDof; ++j) out.append(1, ',').append(heading_of(kDof, i, j));
  out += '\n';
  for (int pose = 0; pose < graph.size(); ++pose) {
    const SquareOf<G>& covariance = (*covariances)[static_cast<std::size_t>(pose)];
    out += graph.label(pose);
    for (int i = 0; i < kDof; ++i)
      for (int j = i; j < kDof; ++j)
        out.append(1, ',').append(eval::significant(covariance(i, j), 9));
    out += '\n';
  }
  return out;
}

template <LieGroup G>
std::string edges_table(const PoseGraph<G>& graph, const std::vector<int>& edges) {
  std::string out = "from,to\n";
  for (const int k : edges) {
    const auto& edge = graph.edges[static_cast<std::size_t>(k)];
    out += graph.label(edge.from) + "," + graph.label(edge.to) + "\n";
  }
  return out;
}

template std::string draw(const PoseGraph2&, const std::vector<SE2d>&, const std::vector<int>&);
template std::string draw(const PoseGraph3&, const std::vector<SE3d>&, const std::vector<int>&);
template Result<std::string> marginals_table(const PoseGraph2&, const std::vector<int>&,
                                             const RobustKernel&);
template Result<std::string> marginals_table(const PoseGraph3&, const std::vector<int>&,
                                             const RobustKernel&);
template std::string edges_table(const PoseGraph2&, const std::vector<int>&);
template std::string edges_table(const PoseGraph3&, const std::vector<int>&);

}  // namespace wayfare::examples
