#pragma once

// A state composed of blocks side by side, each a manifold with names:
//
//   struct Pose {
//     using Value = SE2d;
//     static constexpr BlockNames<3> kNames{"x", "y", "heading"};
//   };
//   struct WheelScale : RandomConstant<1> {                     // see blocks.hpp
//     static constexpr BlockNames<1> kNames{"wheel scale"};
//   };
//   using Cart = State<Pose, WheelScale>;

#include <array>
#include <concepts>
#include <cstddef>
#include <string_view>
#include <tuple>
#include <type_traits>

#include <wayfare/core/manifold.hpp>

namespace wayfare {

/// A name for each error of a block, for reports.
template <int N>
using BlockNames = std::array<std::string_view, static_cast<std::size_t>(N)>;

/// Blocks by type, as couplings and measurements name those they use.
template <class... B>
struct BlockList {
  static constexpr std::size_t kCount = sizeof...(B);  ///< number of blocks
};

/// Number of error components of a block.
template <class B>
inline constexpr int kBlockDof = ManifoldTraits<typename B::Value>::kDof;

/// Required: `Value`, a manifold, and `kNames`. Optional:
/// - a member for the value, with a name of its own in states: `struct Storage { Value x; }` and
///   `kMember = &Storage::x`;
/// - `discretise(dt_s)`, where the block moves by itself (see process.hpp).
template <class B>
concept StateBlock = requires {
  requires Manifold<typename B::Value>;
  { B::kNames } -> std::convertible_to<BlockNames<kBlockDof<B>>>;
};

namespace detail {

template <class B>
consteval bool check_block() {
  constexpr bool kHasValue = requires { typename B::Value; };
  static_assert(kHasValue, "wayfare: a block names the type of its value, using Value = SE2d");
  if constexpr (kHasValue) {
    static_assert(Manifold<typename B::Value>,
                  "wayfare: a block's Value is a manifold, with ManifoldTraits");
    if constexpr (Manifold<typename B::Value>)
      static_assert(StateBlock<B>,
                    "wayfare: a block has a name for each of its errors, static constexpr "
                    "BlockNames<n> kNames");
  }
  return true;
}

template <class B>
struct UnnamedStorage {
  typename B::Value value = manifold_origin<typename B::Value>();
};
template <class B>
struct StorageOf {
  using Type = UnnamedStorage<B>;
};
template <class B>
requires requires { B::kMember; }
struct StorageOf<B> {
  using Type = typename B::Storage;
};

/// A block Block<T> or Block<T, n> on another scalar.
template <class B, class U>
struct BlockOn;
template <template <class> class B, class T, class U>
struct BlockOn<B<T>, U> {
  using Type = B<U>;
};
template <template <class, int> class B, class T, int N, class U>
struct BlockOn<B<T, N>, U> {
  using Type = B<U, N>;
};

/// The number of errors of the blocks before Block.
template <class Block, class... B>
consteval int errors_before() {
  int sum = 0;
  bool found = false;
  ((found = found || std::same_as<Block, B>, sum += found ? 0 : kBlockDof<B>), ...);
  return found ? sum : -1;
}

}  // namespace detail

/// A manifold of all its blocks' values; its errors are those of the blocks one after the other.
template <class... B>
struct State : detail::StorageOf<B>::Type... {
  static_assert((detail::check_block<B>() && ...));
  /// Common to all blocks.
  using Scalar = std::common_type_t<typename ManifoldTraits<typename B::Value>::Scalar...>;
  using Blocks = BlockList<B...>;                    ///< in the order of their errors
  static constexpr int kDof = (kBlockDof<B> + ...);  ///< number of errors
  using Tangent = Eigen::Matrix<Scalar, kDof, 1>;    ///< the errors of all blocks

  /// The place of a block's first error in tangent vectors and covariances.
  template <class Block>
  [[nodiscard]] static constexpr int index() {
    constexpr int kIndex = detail::errors_before<Block, B...>();
    static_assert(kIndex >= 0, "wayfare: the state has no such block");
    return kIndex;
  }

  /// The places of all errors of these blocks.
  template <class... Block>
  [[nodiscard]] static constexpr auto indices() {
    std::array<int, static_cast<std::size_t>((kBlockDof<Block> + ...))> all{};
    std::size_t k = 0;
    const auto append = [&](int first, int count) {
      for (int i = 0; i < count; ++i) all[k++] = first + i;
    };
    (append(index<Block>(), kBlockDof<Block>), ...);
    return all;
  }

  /// Names of all errors, in their order.
  [[nodiscard]] static constexpr BlockNames<kDof> names() {
    BlockNames<kDof> all;
    std::size_t i = 0;
    const auto append = [&](const auto& of_block) {
      for (const std::string_view name : of_block) all[i++] = name;
    };
    (append(B::kNames), ...);
    return all;
  }

  /// The value of a block.
  template <class Block>
  [[nodiscard]] typename Block::Value& get() {
    static_assert(index<Block>() >= 0);
    if constexpr (requires { Block::kMember; })
      return this->*Block::kMember;
    else
      return static_cast<detail::UnnamedStorage<Block>&>(*this).value;
  }
  /// The value of a block.
  template <class Block>
  [[nodiscard]] const typename Block::Value& get() const {
    return const_cast<State&>(*this).template get<Block>();
  }

  /// x ⊞ τ, block by block.
  [[nodiscard]] State plus(const Tangent& tau) const {
    State y;
    ((y.template get<B>() = ManifoldTraits<typename B::Value>::plus(
          get<B>(), tau.template segment<kBlockDof<B>>(index<B>()))),
     ...);
    return y;
  }
  /// τ in x ⊞ τ = *this, block by block.
  [[nodiscard]] Tangent minus(const State& x) const {
    Tangent tau;
    ((tau.template segment<kBlockDof<B>>(index<B>()) =
          ManifoldTraits<typename B::Value>::minus(get<B>(), x.template get<B>())),
     ...);
    return tau;
  }

  /// The same in another scalar type, of blocks that are templates of it, Block<T> or Block<T, n>;
  /// broadcast to every lane of a pack.
  template <class U>
  [[nodiscard]] auto cast() const {
    State<typename detail::BlockOn<B, U>::Type...> y;
    ((y.template get<typename detail::BlockOn<B, U>::Type>() = get<B>().template cast<U>()), ...);
    return y;
  }
};

}  // namespace wayfare
