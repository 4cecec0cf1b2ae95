#include <cstdio>

#include <wayfare/graph/optimise.hpp>

#include "outputs.hpp"

namespace wayfare::examples {
namespace {

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
    for (int i = 0; i < kDof; ++i) {
      for (int j = i; j < kDof; ++j) {
        char number[32];
        std::snprintf(number, sizeof number, ",%.9g", covariance(i, j));
        out += number;
      }
    }
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

template Result<std::string> marginals_table(const PoseGraph2&, const std::vector<int>&,
                                             const RobustKernel&);
template Result<std::string> marginals_table(const PoseGraph3&, const std::vector<int>&,
                                             const RobustKernel&);
template std::string edges_table(const PoseGraph2&, const std::vector<int>&);
template std::string edges_table(const PoseGraph3&, const std::vector<int>&);

}  // namespace wayfare::examples
