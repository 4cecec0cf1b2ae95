#pragma once

// P ← Φ P Φᵀ + Q for a Φ of blocks, of which the structure is known at compile time.

#include <array>
#include <concepts>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include <wayfare/filter/blocks.hpp>
#include <wayfare/filter/state.hpp>

namespace wayfare::detail {

template <class X>
struct IsVector : std::false_type {};
template <class T, int N>
struct IsVector<Eigen::Matrix<T, N, 1>> : std::true_type {};
template <class X>
struct IsTuple : std::false_type {};
template <class... X>
struct IsTuple<std::tuple<X...>> : std::true_type {};

/// Φ times the errors of some blocks; the errors of each block that it moves.
template <class Phi, class... D>
[[nodiscard]] inline auto times(const Phi& phi, const D&... d) {
  if constexpr (!requires { Phi::ColsAtCompileTime; }) {
    return phi(d...);
  } else {
    using T = typename Phi::Scalar;
    using Product = Eigen::Matrix<T, Phi::RowsAtCompileTime, 1>;
    Product product = Product::Constant(T(0));
    int at = 0;
    const auto add = [&](const auto& errors, int count) {
      for (int j = 0; j < count; ++j, ++at)
        for (int i = 0; i < Phi::RowsAtCompileTime; ++i) product[i] += phi(i, at) * errors[j];
    };
    (add(d, D::RowsAtCompileTime), ...);
    return product;
  }
}

/// Calls add(i, j, x) for the elements of a noise covariance that are not zero by its type.
template <class Noise, class Add>
void for_each_element(const Noise& noise, const Add& add) {
  if constexpr (IsVector<Noise>::value) {
    for (int i = 0; i < Noise::RowsAtCompileTime; ++i) add(i, i, noise[i]);
  } else if constexpr (!std::same_as<Noise, NoNoise>) {
    for (int j = 0; j < Noise::ColsAtCompileTime; ++j)
      for (int i = 0; i < Noise::RowsAtCompileTime; ++i) add(i, j, noise(i, j));
  }
}

/// The rows of Φ of the blocks `Moved`, which depend on the blocks `By`, and the noise that is
/// added to them: a matrix over all of them, or a tuple with one for each.
template <class S, class Moved, class By, class Phi, class Noise>
struct BlockRows;
template <class S, class... M, class... B, class Phi, class Noise>
struct BlockRows<S, BlockList<M...>, BlockList<B...>, Phi, Noise> {
  using T = typename S::Scalar;
  static constexpr int kSize = S::kDof;
  static constexpr int kRows = (kBlockDof<M> + ...);
  static constexpr bool kUnchanged = std::same_as<Phi, Unchanged>;
  /// One block by itself, element by element.
  static constexpr bool kDiagonal = kUnchanged || IsVector<Phi>::value;

  Phi phi;
  Noise noise;

  /// Row of Φ · x, of which the elements are `stride` apart, given to set(block, errors of block).
  template <class Set>
  void apply(const T* x, int stride, const Set& set) const {
    const auto of_block = [x, stride]<class Block>(std::type_identity<Block>) {
      Eigen::Matrix<T, kBlockDof<Block>, 1> d;
      for (int k = 0; k < kBlockDof<Block>; ++k)
        d[k] = x[(S::template index<Block>() + k) * stride];
      return d;
    };
    const auto moved = times(phi, of_block(std::type_identity<B>{})...);
    if constexpr (IsTuple<std::remove_const_t<decltype(moved)>>::value) {
      [&]<std::size_t... I>(std::index_sequence<I...>) {
        (set(std::type_identity<M>{}, std::get<I>(moved)), ...);
      }
      (std::index_sequence_for<M...>{});
    } else {
      int at = 0;
      ((set(std::type_identity<M>{}, moved.template segment<kBlockDof<M>>(at)), at += kBlockDof<M>),
       ...);
    }
  }

  [[nodiscard]] T factor(int i) const {
    if constexpr (kUnchanged)
      return T(1);
    else
      return phi[i];
  }

  /// Writes the rows to a dense Φ.
  void fill(const SquareOf<S>& identity, SquareOf<S>& f) const {
    if constexpr (kDiagonal) {
      constexpr int kFirst = (S::template index<M>() + ...);
      for (int i = 0; i < kRows; ++i) f(kFirst + i, kFirst + i) = factor(i);
    } else {
      Eigen::Matrix<T, kSize, kRows> rows;
      left_product(identity.data(), rows.data());
      int row = 0;
      ((f.template middleRows<kBlockDof<M>>(S::template index<M>()) =
            rows.template middleCols<kBlockDof<M>>(row).transpose(),
        row += kBlockDof<M>),
       ...);
    }
  }

  /// The rows of Φ P, one after the other.
  __attribute__((flatten)) void left_product(const T* __restrict p, T* __restrict rows) const {
    for (int c = 0; c < kSize; ++c) {
      int row = 0;
      apply(p + c, kSize, [&](auto block, const auto& d) {
        for (int k = 0; k < kBlockDof<typename decltype(block)::type>; ++k)
          rows[kSize * row++ + c] = d[k];
      });
    }
  }

  void add_noise(T* p) const {
    const auto add_block = [p](int first, const auto& of_block) {
      for_each_element(of_block, [p, first](int i, int j, const T& x) {
        p[kSize * (first + j) + first + i] += x;
      });
    };
    if constexpr (IsTuple<Noise>::value) {
      [&]<std::size_t... I>(std::index_sequence<I...>) {
        (add_block(S::template index<M>(), std::get<I>(noise)), ...);
      }
      (std::index_sequence_for<M...>{});
    } else if constexpr (sizeof...(M) == 1) {
      (add_block(S::template index<M>(), noise), ...);
    } else {
      std::array<int, kRows> at;
      int row = 0;
      const auto append = [&](int first, int count) {
        for (int k = 0; k < count; ++k) at[static_cast<std::size_t>(row++)] = first + k;
      };
      (append(S::template index<M>(), kBlockDof<M>), ...);
      for_each_element(noise, [&](int i, int j, const T& x) {
        p[kSize * at[static_cast<std::size_t>(j)] + at[static_cast<std::size_t>(i)]] += x;
      });
    }
  }
};

/// Φ P Φᵀ between two sets of rows, R before or the same as C; `rows` of Φ P are those of the sets
/// that are not diagonal. Writes both triangles of P.
template <class S, class R, class C>
struct BlockProduct;
template <class S, class... MR, class... BR, class PhiR, class NoiseR, class... MC, class... BC,
          class PhiC, class NoiseC>
struct BlockProduct<S, BlockRows<S, BlockList<MR...>, BlockList<BR...>, PhiR, NoiseR>,
                    BlockRows<S, BlockList<MC...>, BlockList<BC...>, PhiC, NoiseC>> {
  using R = BlockRows<S, BlockList<MR...>, BlockList<BR...>, PhiR, NoiseR>;
  using C = BlockRows<S, BlockList<MC...>, BlockList<BC...>, PhiC, NoiseC>;
  using T = typename S::Scalar;
  static constexpr int n = S::kDof;
  static constexpr bool kSame = std::same_as<R, C>;

  static void set(T* p, int i, int j, const T& x) { p[n * i + j] = p[n * j + i] = x; }

  static void evaluate(const R& r, const C& c, const T* rows_r, const T* rows_c, T* p) {
    if constexpr (R::kDiagonal && C::kDiagonal) {
      if constexpr (!(R::kUnchanged && C::kUnchanged)) both_diagonal(r, c, p);
    } else if constexpr (C::kDiagonal) {
      (one_diagonal<MR...>(c, S::template index<MC>(), rows_r, p), ...);
    } else if constexpr (R::kDiagonal) {
      (one_diagonal<MC...>(r, S::template index<MR>(), rows_c, p), ...);
    } else {
      int row = 0;
      (columns<MR>(c, rows_r, row, p), ...);
    }
  }

  static void both_diagonal(const R& r, const C& c, T* p) {
    constexpr int kRow = (S::template index<MR>() + ...), kCol = (S::template index<MC>() + ...);
    for (int j = 0; j < C::kRows; ++j)
      for (int i = 0; i < (kSame ? j + 1 : R::kRows); ++i)
        set(p, kRow + i, kCol + j, p[n * (kCol + j) + kRow + i] * (r.factor(i) * c.factor(j)));
  }

  /// Rows of Φ P of the blocks `Moved`, times the factors of a diagonal block at `first`.
  template <class... Moved, class Diagonal>
  static void one_diagonal(const Diagonal& diagonal, int first, const T* rows, T* p) {
    int row = 0;
    const auto block = [&](int at, int count) {
      for (int k = 0; k < count; ++k, ++row)
        for (int j = 0; j < Diagonal::kRows; ++j)
          set(p, at + k, first + j, rows[n * row + first + j] * diagonal.factor(j));
    };
    (block(S::template index<Moved>(), kBlockDof<Moved>), ...);
  }

  /// Block M's rows of Φ P times the rows of c; where R and C are the same, on and after the
  /// diagonal. All are computed before the first is written, which is faster.
  template <class M>
  static void columns(const C& c, const T* rows, int& row, T* p) {
    constexpr int kFirst = S::template index<M>();
    T result[kBlockDof<M>][n];
    for (int k = 0; k < kBlockDof<M>; ++k, ++row)
      c.apply(rows + n * row, 1, [&](auto block, const auto& d) {
        using Column = typename decltype(block)::type;
        constexpr int kColumn = S::template index<Column>();
        if constexpr (!kSame || kColumn >= kFirst)
          for (int j = 0; j < kBlockDof<Column>; ++j) result[k][kColumn + j] = d[j];
      });
    const auto write = [&]<class Column>(std::type_identity<Column>) {
      constexpr int kColumn = S::template index<Column>();
      if constexpr (!kSame || kColumn >= kFirst)
        for (int k = 0; k < kBlockDof<M>; ++k)
          for (int j = kColumn == kFirst ? k : 0; j < kBlockDof<Column>; ++j)
            set(p, kFirst + k, kColumn + j, result[k][kColumn + j]);
    };
    (write(std::type_identity<MC>{}), ...);
  }
};

}  // namespace wayfare::detail
