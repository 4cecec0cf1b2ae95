#pragma once

// Incremental sparse Cholesky: A x = b is a sum of terms that each couple one or two variables of
// dimension N. The factor is a tree of cliques (variables eliminated together, and those they
// couple), each with its update for the parent. A new or changed term affects the cliques of its
// variables and their ancestors: only these are reordered and refactorised, from the stored updates
// of the subtrees below.
// (Kaess, Johannsson, Roberts, Ila, Leonard, Dellaert 2012, "iSAM2: Incremental smoothing and
// mapping using the Bayes tree", there with QR; Duff, Reid 1983 for fronts and update matrices.)

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/detail/incremental_order.hpp>
#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

/// The contribution of one term to A and b: [aa ab; abᵀ bb] and [ra; rb].
template <int N>
struct IncrementalTerm {
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;
  Block aa, ab, bb;
  Vector ra, rb;
};

/// What a change of a variable's x is compared with.
enum class ChangeUnit {
  component,  ///< its largest component
  deviation,  ///< √(Δᵀ A_vv Δ): standard deviations of the variable given its neighbours
};

/// Compiled in wayfare::graph for N = 2, 3 and 6.
template <int N>
class IncrementalCholesky {
 public:
  using Term = IncrementalTerm<N>;
  using Vector = typename Term::Vector;

  /// Returns its index; its x is zero. A variable of fewer than N numbers fills the first rows of
  /// its block: its terms are zero in the others.
  int add_variable(int dof = N);
  /// Between variables `a` and `b`; −1 for a term of one variable. Returns the term's index.
  int add_term(int a, int b, const Term& term);
  void set_term(int index, const Term& term);
  /// The origin of this variable's x has changed: everything computed from it is invalid.
  void reset(int variable, const Vector& x);
  /// The next `refactor` reorders and refactorises everything.
  void touch_all() { all_touched_ = true; }

  /// Applies the changes since the last success. On failure `block` is the variable that is not
  /// determined, by the rule of all solvers (FactorOutcome), and the factor is unchanged: undo the
  /// changes (roll_back, set_term, reset), or add the missing terms.
  FactorOutcome refactor();
  /// Removes the newest terms and variables, which must be newer than the last successful
  /// `refactor`, and clears the list of changes.
  void roll_back(int variables, int terms);
  /// Back-substitution from the root, down to where no x changes by more than `threshold`; returns
  /// the variables whose x changed.
  const std::vector<int>& solve(double threshold, ChangeUnit unit = ChangeUnit::component);

  [[nodiscard]] auto x(int variable) const {
    return Eigen::Map<const Vector>(x_.data() + offset(variable));
  }
  /// The terms of a variable, oldest first.
  [[nodiscard]] const std::vector<int>& terms_of(int variable) const {
    return terms_of_[index(variable)];
  }
  [[nodiscard]] int variables() const { return static_cast<int>(clique_of_.size()); }
  [[nodiscard]] int terms() const { return static_cast<int>(ends_.size()); }
  /// Variables eliminated by the last `refactor`, and its number of operations.
  [[nodiscard]] int last_columns() const { return last_columns_; }
  [[nodiscard]] double last_flops() const { return last_flops_; }
  /// Number of operations of a complete factorisation in the current order.
  [[nodiscard]] double total_flops() const { return total_flops_; }
  /// Variables visited by the last `solve`.
  [[nodiscard]] int last_solved() const { return last_solved_; }

 private:
  struct Clique {
    int parent = -1;
    int frontals = 0;
    int pending = 0, made_anew = -1;  // while cliques are rebuilt in the same order
    bool fresh = false;               // not yet visited by `solve`
    std::vector<int> rows;            // variables: frontals in elimination order, then separator
    std::vector<int> children;        // cliques
    // Of the factor the frontals' triangle and the rectangle below it, then the update of the
    // separator; of the right-hand side the frontals' y and the separator's update.
    // Last the information A_vv of each frontal.
    std::vector<double> numbers;
    bool weak = false;           // some pivot lost many digits
    std::vector<double> probes;  // of the rounding of pivots, computed on demand
    [[nodiscard]] int separators() const { return static_cast<int>(rows.size()) - frontals; }
    [[nodiscard]] auto eliminated() const { return std::span(rows).first(index(frontals)); }
    [[nodiscard]] auto separator() const { return std::span(rows).subspan(index(frontals)); }
  };
  /// Columns of the affected part that are eliminated together.
  struct Supernode {
    std::vector<int> frontals;
    std::vector<int> children;  // supernodes, by their last column
    std::vector<int> orphans;
    bool merged = false;
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static std::size_t offset(int variable) { return index(variable) * N; }

  void collect();
  void mark_involving();
  void mark_ancestors(int clique);
  void collect_variables();
  void plan_as_before();
  void plan_in_new_order();
  void join_neighbours();
  void find_structures();
  void gather_structure(int place);
  void absorb_children(int place);
  void make_cliques();
  int acquire();
  void release(int clique);
  FactorOutcome factorise_fresh();
  void commit();
  void forget_touched();

  void find_scales(Clique& clique);
  bool suspicious(Clique& clique) const;
  bool nearly_undetermined(int root);
  void find_probes(Clique& clique);
  [[nodiscard]] Vector scales_of(int variable) const;
  [[nodiscard]] FactorOutcome judge() const;

  void assemble(Clique& clique);
  void number_slots(const Clique& clique);
  void add_terms(Clique& clique, int variable);
  void fill_unused(int variable, double* diagonal, std::ptrdiff_t stride) const;
  const int* later_slots(const Clique& clique);
  int eliminate(Clique& clique);
  static double flops(const Clique& clique);
  void substitute(Clique& clique, double threshold, ChangeUnit unit);
  static double* information_of(Clique& clique, int frontal);
  [[nodiscard]] bool separator_changed(const Clique& clique) const;

  std::vector<Term> terms_;
  std::vector<std::pair<int, int>> ends_;
  std::vector<std::vector<int>> terms_of_;
  std::vector<int> dof_;  // of each variable
  std::vector<double> x_;
  std::vector<Clique> cliques_;
  std::vector<int> free_cliques_;
  std::vector<int> clique_of_;  // −1: not eliminated yet

  std::vector<int> touched_, reset_;
  bool all_touched_ = false, structure_changed_ = false;

  int stamp_ = 0;
  std::vector<int> clique_mark_, expanded_, variable_mark_, reset_mark_, changed_mark_;
  std::vector<int> marked_, orphans_, affected_, fresh_, roots_;
  std::vector<int> place_;  // elimination index of each affected variable; inverse:
  std::vector<int> sequence_;
  IncrementalOrder order_;
  std::vector<std::vector<int>> structures_;
  std::vector<Supernode> supernodes_;
  std::vector<int> seen_, local_, clique_at_;
  std::vector<int> slot_, slots_;
  std::vector<int> ascending_;
  std::vector<double> gathered_, scratch_, scales_;
  std::vector<int> changed_, stack_;
  int last_columns_ = 0, last_solved_ = 0, constrained_ = 0;
  double last_flops_ = 0.0, total_flops_ = 0.0;
  double held_back_ = 0.0;  // the last threshold of `solve`, and its unit
  ChangeUnit held_unit_ = ChangeUnit::component;
};

}  // namespace wayfare
