#pragma once

// Private: the numbers of a line of g2o text, and what may be wrong with them.

#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "io/text/g2o_lines.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {

template <int N>
using Square = Eigen::Matrix<double, N, N>;

/// How errors call an edge, or a prior, which has one vertex.
template <std::size_t N>
std::string name_of(const std::array<std::int64_t, N>& ids) {
  if constexpr (N == 1)
    return "prior of vertex " + std::to_string(ids[0]);
  else
    return "edge " + std::to_string(ids[0]) + " -> " + std::to_string(ids[1]);
}

/// Order of the six numbers of a symmetric matrix: row by row, or that of TORO.
enum class Triangle { rows, toro };

/// Of a matrix in a log; NaN or infinite where it has none.
template <int N>
Square<N> information_of(const Square<N>& matrix, LogMatrix kind) {
  if (kind == LogMatrix::information) return matrix;
  if (kind == LogMatrix::covariance) return matrix.inverse() + Square<N>::Zero();  // no -0
  const Square<N> root = matrix.template triangularView<Eigen::Upper>();
  return root.transpose() * root;
}

class G2oFields {
 public:
  G2oFields(std::string source, const G2oOptions& options)
      : source_(std::move(source)), options_(options) {}

 protected:
  using Tokens = text::Tokens;

  [[nodiscard]] Error fault(std::string message) const {
    return Error{ErrorCode::parse, std::move(message), source_, line_};
  }

  /// Reads `count` finite numbers, which must end the line if `last`.
  Result<void> numbers(Tokens& tokens, double* values, std::size_t count, const std::string& what,
                       bool last) const {
    for (std::size_t i = 0; i < count; ++i) {
      const std::string_view token = tokens.next();
      if (token.empty()) {
        return fault(what + ": expected " + std::to_string(count) + " numbers, found " +
                     std::to_string(i));
      }
      if (!text::to_number(token, values[i]))
        return fault(what + ": not a number: '" + text::printable(token) + "'");
      if (!std::isfinite(values[i]))
        return fault(what + ": not finite: '" + text::printable(token) + "'");
    }
    if (last && !tokens.at_end())
      return fault(what + ": more than " + std::to_string(count) + " numbers");
    return {};
  }

  Result<void> id(Tokens& tokens, std::int64_t& value, const char* what = "vertex") const {
    const std::string_view token = tokens.next();
    if (text::to_number(token, value)) return {};
    return fault("expected a " + std::string(what) + " id, a whole number; found '" +
                 text::printable(token) + "'");
  }

  template <std::size_t N>
  Result<void> ids(Tokens& tokens, std::array<std::int64_t, N>& values) const {
    for (std::int64_t& value : values)
      if (auto done = id(tokens, value); !done) return done;
    if (N == 2 && values[0] == values[N - 1])
      return fault(name_of(values) + " connects a vertex to itself");
    return {};
  }

  template <class G>
  Result<G> pose(Tokens& tokens, const std::string& what, bool last) const {
    double v[Dialect<G>::kNumbers];
    const Result<void> done = numbers(tokens, v, std::size(v), what, last);
    if (!done) return done.error();
    const std::optional<G> value = Dialect<G>::pose(v);
    if (!value) return fault(what + ": the quaternion does not have unit length");
    return *value;
  }

  template <int N>
  Result<void> information(Tokens& tokens, const std::string& name, Square<N>& omega,
                           Triangle order) {
    const auto read = triangle(tokens, name + ": information matrix, upper triangle", order, omega);
    return read ? check_information(name, omega) : read;
  }

  template <int N>
  Result<void> triangle(Tokens& tokens, const std::string& what, Triangle order,
                        Square<N>& matrix) const {
    double v[N * (N + 1) / 2];
    Result<void> done = numbers(tokens, v, std::size(v), what, true);
    if (!done) return done;
    const double* next = v;
    for (int row = 0; row < N; ++row)
      for (int column = row; column < N; ++column)
        matrix(row, column) = matrix(column, row) = *next++;
    if constexpr (N == 3)
      if (order == Triangle::toro)  // xx xy yy θθ xθ yθ
        matrix << v[0], v[1], v[4], v[1], v[2], v[5], v[4], v[5], v[3];
    return {};
  }

  template <int N>
  Result<void> check_information(const std::string& name, Square<N>& omega) {
    // Most matrices pass the cheap test; else the eigenvalues decide.
    if (omega.llt().info() == Eigen::Success) return {};
    const Eigen::SelfAdjointEigenSolver<Square<N>> eigen(omega);
    if (eigen.info() != Eigen::Success)
      return fault(name + ": the eigenvalues of its information matrix do not converge");
    const auto& values = eigen.eigenvalues();
    const double allowed = options_.eigenvalue_tolerance * values.cwiseAbs().maxCoeff();
    if (values.minCoeff() >= -allowed) return {};
    if (options_.indefinite == IndefiniteInformation::refuse) {
      std::string message =
          name + ": its information matrix is not positive semi-definite (eigenvalue ";
      text::append_number(message, values.minCoeff());
      return Error{ErrorCode::invalid, message + ")", source_, line_};
    }
    const auto& axes = eigen.eigenvectors();
    const Square<N> nearest = axes * values.cwiseMax(0.0).asDiagonal() * axes.transpose();
    if (!nearest.allFinite())
      return fault(name + ": its information matrix is too large to be projected");
    omega = 0.5 * nearest + 0.5 * nearest.transpose();
    ++projected_;
    return {};
  }

  template <int N>
  Result<void> log_information(Tokens& tokens, const std::string& name, Square<N>& omega) {
    Square<N> matrix = Square<N>::Zero();
    const auto read = triangle(tokens, name + ": matrix, upper triangle", Triangle::rows, matrix);
    if (!read) return read;
    omega = information_of(matrix, options_.log_matrix);
    if (!omega.allFinite()) return fault(name + ": its matrix has no finite inverse or square");
    return check_information(name, omega);
  }

  std::string source_;
  G2oOptions options_;
  std::size_t line_ = 0;
  std::size_t projected_ = 0;
};

}  // namespace wayfare::io
