#pragma once

// Tables of names and figures as text.

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/statistics.hpp>

namespace wayfare::eval {

/// `value` with a fixed number of decimals, 80 at most; "–" for NaN.
[[nodiscard]] inline std::string fixed(double value, int decimals) {
  if (value != value) return "\u2013";
  char text[400];
  std::snprintf(text, sizeof text, "%.*f", std::clamp(decimals, 0, 80), value);
  return text;
}

/// `mean ± std`.
[[nodiscard]] inline std::string mean_std(double mean, double std, int decimals) {
  return fixed(mean, decimals) + " \u00b1 " + fixed(std, decimals);
}

/// `mean ± std` of the values.
[[nodiscard]] inline std::string mean_std(std::span<const double> values, int decimals) {
  const Summary s = summarise(values);
  return mean_std(s.mean, s.std, decimals);
}

/// `value` with this number of significant digits, 17 at most: more are not in a double.
[[nodiscard]] inline std::string significant(double value, int digits = 3) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", std::clamp(digits, 1, 17), value);
  return text;
}

/// A text table: the first column contains row names, the others figures.
class Table {
 public:
  /// Heading of a column.
  struct Column {
    std::string name;       ///< heading text
    std::string unit = {};  ///< shown in brackets with the name; may be empty
  };

  Table() = default;
  /// Without rows.
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// As many cells as there are columns.
  Table& add_row(std::vector<std::string> cells) {
    WAYFARE_EXPECTS(cells.size() == columns_.size(), "a row has a cell for every column");
    cells.resize(columns_.size());
    rows_.push_back(std::move(cells));
    return *this;
  }

  /// In order.
  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }
  /// Cells row by row, as added.
  [[nodiscard]] const std::vector<std::vector<std::string>>& rows() const { return rows_; }

  /// `name [unit]`.
  [[nodiscard]] static std::string heading(const Column& column) {
    return column.unit.empty() ? column.name : column.name + " [" + column.unit + "]";
  }

  /// Plain text with aligned columns, a rule under the heading, and a newline at the end.
  [[nodiscard]] std::string to_text() const {
    std::vector<std::size_t> widths;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      widths.push_back(width(heading(columns_[c])));
      for (const auto& row : rows_) widths[c] = std::max(widths[c], width(row[c]));
    }
    std::vector<std::string> headings, rule;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      headings.push_back(heading(columns_[c]));
      rule.emplace_back(widths[c], '-');
    }
    std::string text = line(headings, widths) + line(rule, widths);
    for (const auto& row : rows_) text += line(row, widths);
    return text;
  }

 private:
  /// In characters: UTF-8 continuation bytes have no width.
  static std::size_t width(std::string_view text) {
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
      return (static_cast<unsigned char>(c) & 0xc0) != 0x80;
    }));
  }
  static std::string line(const std::vector<std::string>& cells,
                          const std::vector<std::size_t>& widths) {
    std::string text;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::string padding(widths[c] - width(cells[c]), ' ');
      if (c > 0) text += "  ";
      text += c == 0 ? cells[c] + padding : padding + cells[c];  // names left, figures right
    }
    text.erase(text.find_last_not_of(' ') + 1);
    return text += '\n';
  }

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace wayfare::eval
