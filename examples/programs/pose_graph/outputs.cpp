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

  void include(const auto& point) {
    left = std::min(left, point[0]), right = std::max(right, point[0]);
    low = std::min(low, point[1]), high = std::max(high, point[1]);
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
struct Scene {
  PoseGraph<G> graph;
  std::vector<io::GraphLandmark<G>> landmarks;
  double chi2;  ///< without the rejected edges
};

template <class G>
class Panel {
 public:
  Panel(std::string& out, const Scene<G>& scene) : out_(out), graph_(scene.graph), scene_(scene) {
    for (const G& x : graph_.poses) frame_.include(x.translation());
    for (const auto& landmark : scene.landmarks) frame_.include(landmark.position);
  }

  void draw(const char* title, const std::vector<char>& rejected) {
    append(out_, "<text x=\"%.0f\" y=\"20\" text-anchor=\"middle\">%s: sum of e'We %.6g</text>\n",
           0.5 * kPanel_px, title, scene_.chi2);
    const auto is_path = [](const PoseEdge<G>& e) { return std::abs(e.from - e.to) == 1; };
    lines("loop", [&](std::size_t k) { return rejected[k] == 0 && !is_path(graph_.edges[k]); });
    lines("path", [&](std::size_t k) { return rejected[k] == 0 && is_path(graph_.edges[k]); });
    lines("false", [&](std::size_t k) { return rejected[k] != 0; });
    for (const auto& landmark : scene_.landmarks)
      append(out_, "<circle class=\"landmark\" cx=\"%.1f\" cy=\"%.1f\" r=\"2.5\"/>\n",
             frame_.px(landmark.position[0]), frame_.py(landmark.position[1]));
  }

 private:
  const auto& position(int pose) const {
    return graph_.poses[static_cast<std::size_t>(pose)].translation();
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
  const Scene<G>& scene_;
  Frame frame_;
};

template <class G>
double sum_of_errors(const PoseGraph<G>& graph, const std::vector<char>& rejected) {
  double sum = 0.0;
  for (std::size_t k = 0; k < rejected.size(); ++k)
    if (rejected[k] == 0) sum += squared_error(graph, graph.edges[k]);
  return sum;
}

template <class G>
std::string drawing(const Scene<G>& before, const Scene<G>& after,
                    const std::vector<char>& rejected) {
  std::string out;
  append(out,
         "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" "
         "font-family=\"sans-serif\" font-size=\"14\">\n",
         2.0 * kPanel_px, kPanel_px + kTitle_px);
  out +=
      "<style>path{fill:none;stroke-linejoin:round}.path{stroke:#1f4e79;stroke-width:1}"
      ".loop{stroke:#e0a030;stroke-width:.6;stroke-opacity:.7}"
      ".false{stroke:#d02020;stroke-width:.6;stroke-opacity:.6}";
  if (!after.landmarks.empty()) out += ".landmark{fill:#2a8a3c}";
  out += "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  Panel<G>(out, before).draw("before", rejected);
  append(out, "<g transform=\"translate(%.0f 0)\">\n", kPanel_px);
  Panel<G>(out, after).draw("after", rejected);
  append(out, "</g>\n<text x=\"12\" y=\"%.0f\">", kPanel_px + kTitle_px - 6.0);
  out += "<tspan fill=\"#1f4e79\">path</tspan> <tspan fill=\"#c08010\">loops</tspan>";
  if (!after.landmarks.empty()) out += " <tspan fill=\"#2a8a3c\">landmarks</tspan>";
  if (std::find(rejected.begin(), rejected.end(), 1) != rejected.end())
    out += " <tspan fill=\"#d02020\">rejected, not in the sum</tspan>";
  out += "</text>\n</svg>\n";
  return out;
}

constexpr const char* kPlanar[] = {"x", "y", "theta"};
constexpr const char* kSpatial[] = {"x", "y", "z", "rx", "ry", "rz"};

/// "x_theta_m_rad", "x_x_m2".
std::string heading_of(int dof, int i, int j) {
  const auto name = [&](int k) { return std::string(dof == 3 ? kPlanar[k] : kSpatial[k]); };
  const int moves = dof == 3 ? 2 : 3;
  const char* unit = j < moves ? "m2" : i < moves ? "m_rad" : "rad2";
  return name(i) + "_" + name(j) + "_" + unit;
}

template <class G>
std::string heading() {
  std::string out = "vertex";
  for (int i = 0; i < G::kDof; ++i)
    for (int j = i; j < G::kDof; ++j) out.append(1, ',').append(heading_of(G::kDof, i, j));
  return out + '\n';
}

/// Of a variable with the first `size` of a pose's numbers.
template <class G>
void append_row(std::string& out, const std::string& label, const SquareOf<G>& covariance,
                int size) {
  out += label;
  for (int i = 0; i < G::kDof; ++i) {
    for (int j = i; j < G::kDof; ++j) {
      out += ',';
      if (j < size) out += eval::significant(covariance(i, j), 9);
    }
  }
  out += '\n';
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
  PoseGraph<G> start = graph;
  start.poses = before;
  return drawing<G>({start, {}, sum_of_errors(start, is_rejected)},
                    {graph, {}, sum_of_errors(graph, is_rejected)}, is_rejected);
}

template <LieGroup G>
std::string draw(const io::GraphFile<G>& before, const io::GraphFile<G>& after,
                 const std::vector<int>& rejected) {
  std::vector<char> is_rejected(static_cast<std::size_t>(io::to_factor_graph(after).edge_count()),
                                0);
  for (const int k : rejected) is_rejected[static_cast<std::size_t>(k)] = 1;
  const auto scene = [&](const io::GraphFile<G>& file) {
    double sum = 0.0;
    auto edge_rejected = is_rejected.begin();
    io::to_factor_graph(file).each_edge([&](const auto& edge, const auto&, const auto&... x) {
      if (*edge_rejected++ == 0) sum += squared_error(edge, x...);
    });
    return Scene<G>{io::to_pose_graph(file), file.landmarks, sum};
  };
  return drawing<G>(scene(before), scene(after), is_rejected);
}

template <LieGroup G>
Result<std::string> marginals_table(const PoseGraph<G>& graph, const std::vector<int>& rejected,
                                    const RobustKernel& kernel) {
  PoseGraphOptimiser<G> optimiser;
  const auto covariances = optimiser.covariances(without(graph, rejected), kernel);
  if (!covariances) return covariances.error();
  std::string out = heading<G>();
  for (int pose = 0; pose < graph.size(); ++pose)
    append_row<G>(out, graph.label(pose), (*covariances)[static_cast<std::size_t>(pose)], G::kDof);
  return out;
}

template <LieGroup G>
Result<std::string> marginals_table(const io::GraphFile<G>& file) {
  GraphOptimiser<io::LandmarkGraph<G>> optimiser;
  const auto covariances = optimiser.covariances(io::to_factor_graph(file));
  if (!covariances) return covariances.error();
  std::string out = heading<G>();
  auto covariance = covariances->begin();
  for (const auto& vertex : file.vertices)
    append_row<G>(out, std::to_string(vertex.id), *covariance++, G::kDof);
  for (const auto& landmark : file.landmarks)
    append_row<G>(out, std::to_string(landmark.id), *covariance++, LandmarkPosition<G>::kDim);
  return out;
}

template <LieGroup G>
std::string edges_table(const io::GraphFile<G>& file, const std::vector<int>& edges) {
  const auto id = [&](int variable) {
    const auto i = static_cast<std::size_t>(variable), poses = file.vertices.size();
    return std::to_string(i < poses ? file.vertices[i].id : file.landmarks[i - poses].id);
  };
  std::string out = "from,to\n";
  int index = 0;
  auto next = edges.begin();
  io::to_factor_graph(file).each_edge([&](const auto&, const auto& variables, const auto&...) {
    if (next == edges.end() || *next != index++) return;
    out += id(variables.front()) + "," + id(variables.back()) + "\n";
    ++next;
  });
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
template std::string draw(const io::GraphFile<SE2d>&, const io::GraphFile<SE2d>&,
                          const std::vector<int>&);
template std::string draw(const io::GraphFile<SE3d>&, const io::GraphFile<SE3d>&,
                          const std::vector<int>&);
template std::string edges_table(const io::GraphFile<SE2d>&, const std::vector<int>&);
template std::string edges_table(const io::GraphFile<SE3d>&, const std::vector<int>&);
template Result<std::string> marginals_table(const io::GraphFile<SE2d>&);
template Result<std::string> marginals_table(const io::GraphFile<SE3d>&);
template Result<std::string> marginals_table(const PoseGraph2&, const std::vector<int>&,
                                             const RobustKernel&);
template Result<std::string> marginals_table(const PoseGraph3&, const std::vector<int>&,
                                             const RobustKernel&);
template std::string edges_table(const PoseGraph2&, const std::vector<int>&);
template std::string edges_table(const PoseGraph3&, const std::vector<int>&);

}  // namespace wayfare::examples
