#pragma once

// The process of a composed state: blocks that move by themselves, and couplings, which move blocks
// by the values of others. Together they are a ProcessModel for Ekf; Φ P Φᵀ skips the zeros of Φ.
//
//   struct Drive {                                       // the pose, from odometry
//     using Moves = BlockList<Pose>;
//     using By = BlockList<Pose, WheelScale>;
//     using Jacobians = AutomaticJacobians;
//     template <class T>
//     SE2<T> moved(const SE2<T>& pose, const Eigen::Matrix<T, 1, 1>& scale, const Odometry& u)
//         const;
//     Eigen::Vector3d noise(const SE2d&, const auto&, const Odometry& u) const;   // variances
//   };
//   const Process<Cart, Drive, WheelScale> process{Drive{}, WheelScale{}};

#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include <wayfare/core/jacobian.hpp>
#include <wayfare/filter/blocks.hpp>
#include <wayfare/filter/detail/block_rows.hpp>
#include <wayfare/filter/state.hpp>

namespace wayfare {

/// A block with Φ and Q of its own; x⁺ = Φ x.
template <class B>
concept MovingBlock = StateBlock<B> && requires(const B& block) {
  block.discretise(1.0).phi;
  block.discretise(1.0).noise;
};

/// What a coupling makes of the blocks it moves. `moved`: the new value, or a tuple of them.
/// `jacobian`: a matrix, or a callable that maps the errors of `By` to those of `Moves`, a vector
/// or a tuple of them. `noise`: a matrix or vector over all errors moved, or a tuple with one of
/// each.
template <class Moved, class Jacobian, class Noise>
struct CoupledStep {
  Moved moved;        ///< the blocks after the step
  Jacobian jacobian;  ///< of the blocks moved, by those they depend on
  Noise noise;        ///< covariance added
};
/// The types are those of its members.
template <class Moved, class Jacobian, class Noise>
CoupledStep(Moved, Jacobian, Noise) -> CoupledStep<Moved, Jacobian, Noise>;

namespace detail {

template <class C, class S, class U, class By>
struct CouplingTraits;
template <class C, class S, class U, class... B>
struct CouplingTraits<C, S, U, BlockList<B...>> {
  static constexpr bool kGiven = requires(const C& c, const U& u, const S& x) {
    c.step(x.template get<B>()..., u).jacobian;
  };
  static constexpr bool kMoves = requires(const C& c, const U& u, const S& x) {
    c.moved(x.template get<B>()..., u);
  };
  static constexpr bool kHasNoise = requires(const C& c, const U& u, const S& x) {
    c.noise(x.template get<B>()..., u);
  };
};

template <class List>
struct OnlyBlock;
template <class B>
struct OnlyBlock<BlockList<B>> {
  using Value = typename B::Value;
};

}  // namespace detail

/// Required: `Moves` and `By`, lists of blocks, and `moved(values of By..., u)`, the new value of
/// the block it moves, with `noise(values of By..., u)`, its covariance or variances. The Jacobian
/// is numeric, or automatic with `using Jacobians = AutomaticJacobians`. Where it is given, and for
/// more than one block, `step(values of By..., u)`, a CoupledStep, instead of both.
template <class C, class S, class U>
concept Coupling = requires {
  typename C::Moves;
  typename C::By;
}
&&(detail::CouplingTraits<C, S, U, typename C::By>::kGiven ||
   (detail::CouplingTraits<C, S, U, typename C::By>::kMoves &&
    detail::CouplingTraits<C, S, U, typename C::By>::kHasNoise));

namespace detail {

/// What a type lacks to be a coupling, in words.
template <class C, class S, class U>
consteval bool check_coupling() {
  constexpr bool kNamesBlocks = requires {
    typename C::Moves;
    typename C::By;
  };
  static_assert(kNamesBlocks,
                "wayfare: a part of a process is a block with discretise(dt_s), or a coupling, "
                "which names the blocks it moves and those it depends on, using Moves = "
                "BlockList<X> and using By = BlockList<X, Y>");
  if constexpr (kNamesBlocks) {
    using Traits = CouplingTraits<C, S, U, typename C::By>;
    static_assert(Traits::kGiven || Traits::kMoves,
                  "wayfare: a coupling has a const member moved(x, y, u), which takes the values "
                  "of its blocks By and the input, or step(x, y, u)");
    static_assert(Traits::kGiven || Traits::kHasNoise,
                  "wayfare: a coupling has a const member noise(x, y, u), the covariance or the "
                  "variances of what it moves");
  }
  return true;
}

/// The blocks a part of a process moves, and those it depends on.
template <class P>
struct PartBlocks {
  using Moves = typename P::Moves;
  using By = typename P::By;
};
template <MovingBlock P>
struct PartBlocks<P> {
  using Moves = BlockList<P>;
  using By = BlockList<P>;
};

template <class Block, class... M>
consteval int count_of(BlockList<M...>) {
  return (0 + ... + (std::same_as<Block, M> ? 1 : 0));
}
template <class Block, class... P>
consteval bool check_moved() {
  static_assert((0 + ... + count_of<Block>(typename PartBlocks<P>::Moves{})) == 1,
                "wayfare: each block of a state is moved by exactly one part of its process");
  return true;
}

struct NotDiscretised {};
template <class P>
auto discretise(const P& part, double dt_s) {
  if constexpr (MovingBlock<P>)
    return part.discretise(dt_s);
  else
    return NotDiscretised{};
}

/// The rows of all parts, an aggregate: they are made in place, since they are long to copy.
template <std::size_t I, class R>
struct RowsAt {
  R rows;
};
template <class Index, class... R>
struct RowSet;
template <std::size_t... I, class... R>
struct RowSet<std::index_sequence<I...>, R...> : RowsAt<I, R>... {};

template <std::size_t I, class R>
[[nodiscard]] const R& rows_at(const RowsAt<I, R>& set) {
  return set.rows;
}

/// ΦPΦᵀ + Q of all rows. Flattened: calls of maps that are not inlined cost three times as much.
template <class S, std::size_t... Index, class... R>
__attribute__((flatten)) void propagate(const RowSet<std::index_sequence<Index...>, R...>& parts,
                                        typename S::Scalar* __restrict p) {
  using T = typename S::Scalar;
  constexpr std::size_t kParts = sizeof...(R);
  constexpr auto kFirst = [] {
    std::array<int, kParts + 1> first{};
    std::size_t i = 0;
    ((first[i + 1] = first[i] + (R::kDiagonal ? 0 : R::kRows), ++i), ...);
    return first;
  }();
  T rows[S::kDof * (kFirst[kParts] > 0 ? kFirst[kParts] : 1)];
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    const auto left = [&]<std::size_t K>(std::integral_constant<std::size_t, K>) {
      if constexpr (!std::tuple_element_t<K, std::tuple<R...>>::kDiagonal)
        rows_at<K>(parts).left_product(p, rows + S::kDof * kFirst[K]);
    };
    (left(std::integral_constant<std::size_t, I>{}), ...);
    const auto pair = [&]<std::size_t K, std::size_t L>(std::integral_constant<std::size_t, K>,
                                                        std::integral_constant<std::size_t, L>) {
      if constexpr (K <= L)
        BlockProduct<S, std::tuple_element_t<K, std::tuple<R...>>,
                     std::tuple_element_t<L, std::tuple<R...>>>::evaluate(rows_at<K>(parts),
                                                                          rows_at<L>(parts),
                                                                          rows +
                                                                              S::kDof * kFirst[K],
                                                                          rows +
                                                                              S::kDof * kFirst[L],
                                                                          p);
    };
    const auto with_all = [&](auto k) { (pair(k, std::integral_constant<std::size_t, I>{}), ...); };
    (with_all(std::integral_constant<std::size_t, I>{}), ...);
    (rows_at<I>(parts).add_noise(p), ...);
  }
  (std::make_index_sequence<kParts>{});
}

}  // namespace detail

/// A step of a composed process: the new state, and Φ and Q by their rows, one part of the process
/// after the other.
template <class S, class... Rows>
struct ComposedStep {
  using Square = SquareOf<S>;  ///< a covariance of the state's errors
  /// Rows of Φ and Q of each part.
  detail::RowSet<std::index_sequence_for<Rows...>, Rows...> rows;
  S state;  ///< after the step

  /// P ← Φ P Φᵀ + Q, exactly symmetric.
  void propagate(Square& p) const { detail::propagate<S>(rows, p.data()); }

  /// Φ as a dense matrix.
  [[nodiscard]] Square phi() const {
    using T = typename S::Scalar;
    Square identity = Square::Constant(T(0));  // faster than Eigen's
    identity.diagonal().setConstant(T(1));
    Square f = identity;
    for_each([&](const auto& part) { part.fill(identity, f); });
    return f;
  }
  /// Q as a dense matrix.
  [[nodiscard]] Square q() const {
    Square noise = Square::Constant(typename S::Scalar(0));
    for_each([&](const auto& part) { part.add_noise(noise.data()); });
    return noise;
  }

 private:
  template <class F>
  void for_each(const F& f) const {
    [&]<std::size_t... I>(std::index_sequence<I...>) { (f(detail::rows_at<I>(rows)), ...); }
    (std::index_sequence_for<Rows...>{});
  }
};

/// Parts: the blocks that move by themselves and the couplings, in any order; together they move
/// each block of the state S once. The input has a member `dt_s`, or is the time itself. All parts
/// use the values at the beginning of the step.
template <class S, class... Part>
class Process {
 public:
  /// Copies the parts.
  explicit Process(const Part&... part) : parts_(part...) {}

  /// Computes Φ and Q of the blocks that move by themselves for steps of exactly this length
  /// beforehand. Results do not change.
  void prepare(double dt_s) {
    prepared_ = std::apply(
        [dt_s](const auto&... part) { return Steps(detail::discretise(part, dt_s)...); }, parts_);
    prepared_dt_s_ = dt_s;
  }

  /// The step from `x` with the input `u`, a ComposedStep.
  template <class U>
  [[nodiscard]] auto operator()(const S& x, const U& u) const {
    static_assert(check<U>(typename S::Blocks{}));
    double dt_s;
    if constexpr (requires { u.dt_s; })
      dt_s = u.dt_s;
    else
      dt_s = u;
    S next = x;
    const auto* steps = prepared_dt_s_ == dt_s ? &*prepared_ : nullptr;
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
      // The rows come first: they set `next`.
      return ComposedStep<S, decltype(move(std::get<I>(parts_), &std::get<I>(*steps), x, u, dt_s,
                                           next))...>{
          {{move(std::get<I>(parts_), steps ? &std::get<I>(*steps) : nullptr, x, u, dt_s,
                 next)}...},
          next};
    }
    (std::index_sequence_for<Part...>{});
  }

 private:
  /// The steps of the blocks that move by themselves.
  using Steps = std::tuple<decltype(detail::discretise(std::declval<const Part&>(), 1.0))...>;

  template <class P, class U>
  static consteval void check_part() {
    if constexpr (!MovingBlock<P>) detail::check_coupling<P, S, U>();
  }
  template <class U, class... B>
  static consteval bool check(BlockList<B...>) {
    (check_part<Part, U>(), ...);
    (detail::check_moved<B, Part...>(), ...);
    return true;
  }

  template <class P, class Step, class U>
  auto move(const P& part, const Step* prepared, const S& x, const U& u, double dt_s,
            S& next) const {
    if constexpr (MovingBlock<P>) {
      const Step step = prepared ? *prepared : part.discretise(dt_s);
      using Phi = decltype(step.phi);
      auto& value = next.template get<P>();
      if constexpr (detail::IsVector<Phi>::value)
        value.array() *= step.phi.array();
      else if constexpr (!std::same_as<Phi, Unchanged>)
        value = detail::times(step.phi, value);
      return rows<BlockList<P>, BlockList<P>>(step.phi, step.noise);
    } else {
      return couple(part, x, u, next, typename P::Moves{}, typename P::By{});
    }
  }

  template <class C, class U, class... M, class... B>
  static auto couple(const C& coupling, const S& x, const U& u, S& next, BlockList<M...>,
                     BlockList<B...>) {
    if constexpr (detail::CouplingTraits<C, S, U, BlockList<B...>>::kGiven) {
      const auto step = coupling.step(x.template get<B>()..., u);
      if constexpr (detail::IsTuple<std::remove_cvref_t<decltype(step.moved)>>::value)
        std::tie(next.template get<M>()...) = step.moved;
      else
        ((next.template get<M>() = step.moved), ...);
      return rows<BlockList<M...>, BlockList<B...>>(step.jacobian, step.noise);
    } else {
      static_assert(sizeof...(M) == 1,
                    "wayfare: a coupling that moves several blocks gives its Jacobian, with a "
                    "const member step(x, y, u); or write one coupling for each");
      using Value = typename detail::OnlyBlock<BlockList<M...>>::Value;
      JacobianBlocks<Value, typename B::Value...> blocks;
      const auto f = [&](const auto&... value) { return coupling.moved(value..., u); };
      ((next.template get<M>() = differentiate<C, Value>(f, blocks, x.template get<B>()...)), ...);
      return rows<BlockList<M...>, BlockList<B...>>(detail::side_by_side(blocks),
                                                    coupling.noise(x.template get<B>()..., u));
    }
  }

  template <class Moves, class By, class Phi, class Noise>
  static detail::BlockRows<S, Moves, By, Phi, Noise> rows(const Phi& phi, const Noise& noise) {
    return {phi, noise};
  }

  std::tuple<Part...> parts_;
  std::optional<Steps> prepared_;
  double prepared_dt_s_ = std::numeric_limits<double>::quiet_NaN();  // none
};

}  // namespace wayfare
