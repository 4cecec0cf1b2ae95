#include <algorithm>
#include <cstdlib>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "graph/lists.hpp"

namespace wayfare {
namespace {

using detail::at;

std::vector<int> anchors_of(const auto& graph) {
  return graph.fixed.empty() ? std::vector<int>{0} : graph.fixed;
}

/// The pose of the edge's other end from the one at `pose`.
template <class G>
G across(const PoseEdge<G>& edge, int pose, const G& x) {
  return edge.from == pose ? x * edge.measurement : x * edge.measurement.inverse();
}

/// For each pose k the edge to k + 1, or −1.
template <class G>
std::vector<int> chain_of(const PoseGraph<G>& graph) {
  std::vector<int> chain(graph.poses.size(), -1);
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const PoseEdge<G>& edge = graph.edges[e];
    if (std::abs(edge.from - edge.to) != 1) continue;
    int& link = chain[at(std::min(edge.from, edge.to))];
    if (link < 0 || (graph.edges[at(link)].robust && !edge.robust)) link = static_cast<int>(e);
  }
  return chain;
}

/// The edges of each pose, in order.
detail::Lists<int> edges_by_pose(const auto& graph) {
  return {graph.poses.size(), [&](const auto& visit) {
            for (std::size_t e = 0; e < graph.edges.size(); ++e)
              for (const int end : {graph.edges[e].from, graph.edges[e].to})
                visit(end, static_cast<int>(e));
          }};
}

/// Sets the poses, unless sums of measurements overflow.
template <class G>
Result<void> take(PoseGraph<G>& graph, std::vector<G> x) {
  for (int pose = 0; pose < graph.size(); ++pose)
    if (!detail::is_finite(x[at(pose)]))
      return Error{ErrorCode::degenerate,
                   "pose " + graph.label(pose) + " is too far away: its coordinates overflow"};
  graph.poses = std::move(x);
  return {};
}

/// The size of an edge's uncertainty, var x + var y (+ var z) + lever² of the rotations' variances,
/// from the diagonal of its information; infinite without information.
template <class G>
double uncertainty(const PoseEdge<G>& edge) {
  // In space, of a quaternion's vector part: half the angle.
  constexpr double kLever_m = std::is_same_v<G, SE3d> ? 4.0 : 2.0;
  const auto variances = edge.information.diagonal().cwiseInverse().eval();
  const Eigen::Index place = edge.measurement.translation().size();
  return variances.head(place).sum() +
         kLever_m * kLever_m * variances.tail(variances.size() - place).sum();
}

/// Items with the smallest key first, those of equal keys in the order of `push`.
template <class T>
class LeastFirst {
 public:
  void push(double key, const T& item) {
    heap_.push_back({key, pushed_++, item});
    std::push_heap(heap_.begin(), heap_.end(), After());
  }
  std::pair<double, T> pop() {
    std::pop_heap(heap_.begin(), heap_.end(), After());
    const Entry least = heap_.back();
    heap_.pop_back();
    return {least.key, least.item};
  }
  [[nodiscard]] bool empty() const { return heap_.empty(); }

 private:
  struct Entry {
    double key;
    std::size_t number;
    T item;
  };
  struct After {
    bool operator()(const Entry& a, const Entry& b) const {
      return a.key > b.key || (a.key == b.key && a.number > b.number);
    }
  };
  std::vector<Entry> heap_;
  std::size_t pushed_ = 0;
};

/// A pose and the edge that reaches it, −1 for an anchor.
struct Branch {
  int pose, edge;
};

}  // namespace

template <LieGroup G>
Result<void> start_from_odometry(PoseGraph<G>& graph) {
  if (auto valid = validate(graph); !valid) return valid;
  const std::vector<int> chain = chain_of(graph);
  std::vector<G> x = graph.poses;
  std::vector<char> placed(x.size(), 0);
  int first = graph.size();
  for (const int a : anchors_of(graph)) placed[at(a)] = 1, first = std::min(first, a);
  const auto place = [&](int pose, int neighbour) {
    const int link = chain[at(std::min(pose, neighbour))];
    if (link >= 0) x[at(pose)] = across(graph.edges[at(link)], neighbour, x[at(neighbour)]);
    return link >= 0;
  };
  const auto broken = [&](int a, int b) {
    return Error{ErrorCode::degenerate,
                 "no odometry edge joins poses " + graph.label(a) + " and " + graph.label(b)};
  };
  for (int k = first - 1; k >= 0; --k)
    if (!place(k, k + 1)) return broken(k, k + 1);
  for (int k = first + 1; k < graph.size(); ++k)
    if (placed[at(k)] == 0 && !place(k, k - 1)) return broken(k - 1, k);
  return take(graph, std::move(x));
}

template <LieGroup G>
Result<void> start_from_tree(PoseGraph<G>& graph, TreeEdges rather) {
  if (auto valid = validate(graph); !valid) return valid;
  const auto edges_at = edges_by_pose(graph);
  // The least uncertain path first; those over untrusted edges only when no other is left.
  LeastFirst<Branch> open, later;
  std::vector<G> x = graph.poses;
  std::vector<char> placed(x.size(), 0);
  for (const int a : anchors_of(graph)) open.push(0.0, {a, -1});
  const auto place = [&](double size, const Branch& branch) {
    if (placed[at(branch.pose)] != 0) return;
    placed[at(branch.pose)] = 1;
    if (branch.edge >= 0) {
      const PoseEdge<G>& edge = graph.edges[at(branch.edge)];
      const int parent = edge.from == branch.pose ? edge.to : edge.from;
      x[at(branch.pose)] = across(edge, parent, x[at(parent)]);
    }
    for (const int e : edges_at[branch.pose]) {
      const PoseEdge<G>& edge = graph.edges[at(e)];
      const bool waits = rather == TreeEdges::trusted_first && edge.robust;
      (waits ? later : open)
          .push(size + uncertainty(edge), {edge.from == branch.pose ? edge.to : edge.from, e});
    }
  };
  for (; !open.empty(); open.empty() ? std::swap(open, later) : void()) {
    const auto [size, branch] = open.pop();
    place(size, branch);
  }
  return take(graph, std::move(x));
}

template Result<void> start_from_odometry(PoseGraph<SE2d>&);
template Result<void> start_from_odometry(PoseGraph<SE3d>&);
template Result<void> start_from_tree(PoseGraph<SE2d>&, TreeEdges);
template Result<void> start_from_tree(PoseGraph<SE3d>&, TreeEdges);

}  // namespace wayfare
