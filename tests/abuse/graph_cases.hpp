#pragma once

// Pose graphs that nobody should optimise, and all that can be done with a graph.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "abuse/abuse.hpp"
#include "graph/growth.hpp"

namespace wayfare::tests {

using Bits = std::vector<std::uint64_t>;

template <class Derived>
void add_bits(Bits& all, const Eigen::MatrixBase<Derived>& numbers) {
  for (const double v : numbers.reshaped()) all.push_back(std::bit_cast<std::uint64_t>(v));
}

/// Every number of the poses, also those that are not equal to themselves.
template <class G>
[[nodiscard]] Bits bits_of(const std::vector<G>& poses) {
  Bits all;
  for (const G& x : poses) {
    add_bits(all, x.translation());
    add_bits(all, x.rotation().matrix());
  }
  return all;
}

/// And of the whole graph.
template <class G>
[[nodiscard]] Bits bits_of(const PoseGraph<G>& graph) {
  Bits all = bits_of(graph.poses);
  for (const auto& edge : graph.edges) {
    const Bits measured = bits_of(std::vector<G>{edge.measurement});
    all.insert(all.end(), measured.begin(), measured.end());
    add_bits(all, edge.information);
    for (const int v : {edge.from, edge.to, edge.robust ? 1 : 0})
      all.push_back(static_cast<std::uint64_t>(v));
  }
  for (const int pose : graph.fixed) all.push_back(static_cast<std::uint64_t>(pose));
  for (const auto& label : graph.labels) all.push_back(std::hash<std::string>()(label));
  return all;
}

template <class G>
[[nodiscard]] bool all_finite(const std::vector<G>& poses) {
  return std::all_of(poses.begin(), poses.end(), [](const G& x) { return detail::is_finite(x); });
}

template <class G>
[[nodiscard]] G moved_to(double x) {
  return G(G::Vector::Constant(x), G().rotation());
}

template <class T>
[[nodiscard]] Result<void> outcome(const Result<T>& result) {
  if (!result) return result.error();
  return {};
}

/// A change of a graph, or a computation on it.
template <class G>
struct Named {
  std::string name;
  std::function<void(PoseGraph<G>&)> change;
};
template <class G>
struct Computation {
  std::string name;
  std::function<Result<void>(PoseGraph<G>&)> run;
};

/// Faults of a graph of twelve poses that every computation refuses.
template <class G>
[[nodiscard]] std::vector<Named<G>> faults() {
  constexpr int kLeast = std::numeric_limits<int>::min(), kMost = std::numeric_limits<int>::max();
  using Graph = PoseGraph<G>;
  std::vector<Named<G>> all{
      {"no poses", [](Graph& g) { g.poses.clear(); }},
      {"nothing", [](Graph& g) { g = {}; }},
      {"no edges", [](Graph& g) { g.edges.clear(); }},
      {"self edge", [](Graph& g) { g.edges[3].to = g.edges[3].from; }},
      {"lonely pose", [](Graph& g) { g.add_pose(G()); }},
      {"second part",
       [](Graph& g) {
         g.add_pose(G());
         g.edges.push_back({12, g.add_pose(G()), G()});
       }},
      {"not symmetric", [](Graph& g) { g.edges[2].information(0, 1) += 1e3; }},
      {"zero information", [](Graph& g) { g.edges[2].information.setZero(); }},
      {"negative information", [](Graph& g) { g.edges[2].information *= -1.0; }}};
  for (const int pose : {kLeast, -1, 12, kMost}) {
    const std::string name = std::to_string(pose);
    all.push_back({"from " + name, [=](Graph& g) { g.edges[5].from = pose; }});
    all.push_back({"to " + name, [=](Graph& g) { g.edges[5].to = pose; }});
    all.push_back({"fixed " + name, [=](Graph& g) { g.fixed = {0, pose}; }});
  }
  for (const double bad : kNotFinite) {
    const std::string name = std::to_string(bad);
    all.push_back({"pose " + name, [=](Graph& g) { g.poses[7] = moved_to<G>(bad); }});
    all.push_back({"fixed pose " + name, [=](Graph& g) { g.poses[0] = moved_to<G>(bad); }});
    all.push_back(
        {"measured " + name, [=](Graph& g) { g.edges[2].measurement = moved_to<G>(bad); }});
    all.push_back({"information " + name, [=](Graph& g) { g.edges[2].information(1, 1) = bad; }});
  }
  return all;
}

/// Graphs that are unusual, but none of them has a fault that validate must find.
template <class G>
[[nodiscard]] std::vector<Named<G>> oddities() {
  using Graph = PoseGraph<G>;
  const auto each_edge = [](const auto& change) {
    return [change](Graph& g) {
      for (auto& edge : g.edges) change(edge);
    };
  };
  std::vector<Named<G>> all{
      {"as it is", [](Graph&) {}},
      {"one pose", [](Graph& g) { g.poses.resize(1), g.edges.clear(); }},
      {"all fixed",
       [](Graph& g) {
         for (int i = 0; i < g.size(); ++i) g.fixed.push_back(i);
       }},
      {"fixed twice",
       [](Graph& g) {
         g.fixed = {5, 5, 0, 5};
       }},
      {"labels",
       [](Graph& g) {
         g.labels = {"", "a", "a"};
         g.labels.resize(40);
       }},
      {"a hundred equal edges", [](Graph& g) { g.edges.resize(g.edges.size() + 100, g.edges[4]); }},
      {"there and back",
       [](Graph& g) {
         for (auto edges = g.edges; auto& e : edges) std::swap(e.from, e.to), g.edges.push_back(e);
       }},
      {"all robust", each_edge([](auto& e) { e.robust = true; })},
      {"equal poses", [](Graph& g) { std::fill(g.poses.begin(), g.poses.end(), G()); }},
      {"one axis", [](Graph& g) {
         SquareOf<G> only = SquareOf<G>::Zero();
         only(0, 0) = 1.0;
         g.edges.push_back({0, 11, G(), only, true});
       }}};
  for (const double size : {1e9, 1e30, 1e150, 1e160, 1e300, 1.7e308}) {
    const std::string name = std::to_string(static_cast<int>(std::log10(size)));
    all.push_back({"poses at 1e" + name, [=](Graph& g) {
                     for (auto& x : g.poses) x = moved_to<G>(size) * x;
                   }});
    all.push_back({"one pose at 1e" + name, [=](Graph& g) { g.poses[6] = moved_to<G>(size); }});
    all.push_back({"steps of 1e" + name,
                   each_edge([=](auto& e) { e.measurement = moved_to<G>(size) * e.measurement; })});
    all.push_back(
        {"one step of 1e" + name, [=](Graph& g) { g.edges[6].measurement = moved_to<G>(size); }});
    all.push_back({"fitting steps of 1e" + name, [=](Graph& g) {
                     for (auto& e : g.edges) {
                       e.measurement = G(size * e.measurement.translation(), G().rotation());
                       g.poses[static_cast<std::size_t>(std::max(e.from, e.to))] =
                           moved_to<G>(size * std::max(e.from, e.to));
                     }
                   }});
    for (const double factor : {size, 1.0 / size}) {
      all.push_back(
          {"information of " + std::to_string(factor > 1.0) + " 1e" + name,
           each_edge([=](auto& e) { e.information = factor * SquareOf<G>::Identity(); })});
      all.push_back({"one information of " + std::to_string(factor > 1.0) + " 1e" + name,
                     [=](Graph& g) { g.edges[6].information *= factor / 100.0; }});
    }
  }
  return all;
}

/// All that computes poses; those of `graph` are the result.
template <class G>
[[nodiscard]] std::vector<Computation<G>> computations() {
  using Graph = PoseGraph<G>;
  return {
      {"Gauss-Newton", [](Graph& g) { return outcome(optimise(g)); }},
      {"Levenberg-Marquardt",
       [](Graph& g) {
         return outcome(optimise(g, {.method = OptimiseMethod::levenberg_marquardt}));
       }},
      {"Cauchy",
       [](Graph& g) {
         return outcome(optimise(g, {.kernel = {RobustKernelKind::cauchy, 2.0}}));
       }},
      {"covariances", [](Graph& g) { return outcome(PoseGraphOptimiser<G>().covariances(g)); }},
      {"GNC", [](Graph& g) { return outcome(optimise_gnc(g)); }},
      {"GNC as given",
       [](Graph& g) {
         return outcome(optimise_gnc(
             g, {.loss = GncLoss::geman_mcclure, .max_rounds = 20, .start_from_trusted = false}));
       }},
      {"odometry", [](Graph& g) { return start_from(g, StartMethod::odometry); }},
      {"tree", [](Graph& g) { return start_from(g, StartMethod::tree); }},
      {"trusted tree", [](Graph& g) { return start_from_tree(g, TreeEdges::trusted_first); }},
      {"chordal", [](Graph& g) { return start_from(g, StartMethod::chordal); }},
      {"incremental", [](Graph& g) {
         IncrementalOptimiser<G> growing;
         auto done = growing.append(g);
         if (done) done = outcome(growing.update());
         if (done) g.poses = growing.poses();
         return done;
       }}};
}

/// A walk of twelve poses, which may be changed.
template <class G>
[[nodiscard]] PoseGraph<G> twelve(std::uint64_t seed = 1) {
  Rng rng(seed);
  return random_walk<G>(rng, 12);
}

inline int any_of(Rng& rng, int size) { return static_cast<int>(rng.below(size)); }

/// A true measurement with noise between any two poses, or of the last one.
template <class G>
[[nodiscard]] PoseEdge<G> random_edge(Rng& rng, const PoseGraph<G>& graph) {
  const int to = rng.below(2) == 0 ? graph.size() - 1 : any_of(rng, graph.size());
  const int from = to > 0 && rng.below(2) == 0 ? to - 1 : any_of(rng, graph.size());
  const G between = graph.poses[static_cast<std::size_t>(from)].inverse() *
                    graph.poses[static_cast<std::size_t>(to)];
  PoseEdge<G> edge{from, to, between.plus(random_tangent<G>(rng, 0.1))};
  edge.information *= rng.uniform(5.0, 50.0);
  if (rng.below(8) == 0) edge.information(G::kDof - 1, G::kDof - 1) = 0.0;  // no heading
  edge.robust = rng.below(3) == 0;
  return edge;
}

/// One of the faults that validate_edge refuses, or an error too large to square.
template <class G>
void spoil(Rng& rng, PoseEdge<G>& edge) {
  switch (rng.below(6)) {
    case 0:
      edge.to = edge.from;
      break;
    case 1:
      edge.from = rng.below(2) == 0 ? -1 : 1'000'000'000;
      break;
    case 2:
      edge.measurement = moved_to<G>(kNotFinite[rng.below(3)]);
      break;
    case 3:
      edge.information(0, 0) = rng.below(2) == 0 ? kNan : -1.0;
      break;
    case 4:
      edge.information.setZero();
      break;
    default:
      edge.measurement = moved_to<G>(1e200);
  }
}

}  // namespace wayfare::tests
