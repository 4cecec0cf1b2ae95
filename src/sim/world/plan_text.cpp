#include <wayfare/sim/floor_plan.hpp>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace wayfare::sim {
namespace {

constexpr int kMaxPictureSide = 8192;

std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while ((at = line.find_first_not_of(" \t", at)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

std::string in_quotes(std::string_view word) {
  std::string text(1, '\'');
  text.append(word.substr(0, 40));
  text.push_back('\'');
  return text;
}

std::optional<double> to_number(std::string_view word) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool whole = code == std::errc() && end == word.data() + word.size();
  return whole && std::abs(value) < 1e6 ? std::optional(value) : std::nullopt;
}

class Reader {
 public:
  Reader(std::string_view text, std::string_view source) : rest_(text), source_(source) {}

  Result<PlannedRoute> read() {
    while (!rest_.empty() && !in_picture_) {
      next_line();
      if (auto done = read_header_line(); !done) return done.error();
    }
    while (!rest_.empty()) {
      next_line();
      if (auto done = read_picture_line(); !done) return done.error();
    }
    return finish();
  }

 private:
  struct Stop {
    std::string name;
    std::size_t line;
  };

  void next_line() {
    line_ = take_line(rest_);
    ++line_number_;
  }

  [[nodiscard]] Error fail(std::string message, ErrorCode code = ErrorCode::parse) const {
    return fail_at(line_number_, std::move(message), code);
  }
  [[nodiscard]] Error fail_at(std::size_t line, std::string message, ErrorCode code) const {
    return Error{code, std::move(message), source_, line};
  }

  Result<void> read_header_line() {
    const std::vector<std::string_view> words = split_words(line_);
    if (words.empty() || words[0].front() == '#') return {};
    if (words[0] == "wall") return read_wall(words);
    if (words[0] == "place") return read_place(words);
    if (words[0] == "route") return read_route(words);
    if (words[0] == "metres_per_character") return read_cell_size(words);
    if (words[0] == "picture" && words.size() == 1) {
      in_picture_ = true;
      if (mask_.cell_m > 0.0) return {};
      return fail("a picture needs a line 'metres_per_character NUMBER' before it");
    }
    return fail("expected wall, place, route, metres_per_character or picture, found " +
                in_quotes(words[0]));
  }

  // Numbers of `words` from `first` on, `count` of them.
  Result<std::vector<double>> numbers(const std::vector<std::string_view>& words, std::size_t first,
                                      std::size_t count, const char* usage) const {
    std::vector<double> values;
    if (words.size() != first + count) return fail("expected " + in_quotes(usage));
    for (std::size_t i = first; i < words.size(); ++i) {
      const std::optional<double> value = to_number(words[i]);
      if (!value) {
        return fail(in_quotes(words[i]) + " is not a number of metres; expected " +
                    in_quotes(usage));
      }
      values.push_back(*value);
    }
    return values;
  }

  Result<void> read_wall(const std::vector<std::string_view>& words) {
    const auto v = numbers(words, 1, 4, "wall X1 Y1 X2 Y2");
    if (!v) return v.error();
    const Segment wall{{(*v)[0], (*v)[1]}, {(*v)[2], (*v)[3]}};
    if ((wall.b_m - wall.a_m).norm() < 1e-6) return fail("this wall has no length");
    walls_.push_back(wall);
    return {};
  }

  Result<void> read_place(const std::vector<std::string_view>& words) {
    const auto v = numbers(words, 2, 2, "place NAME X Y");
    if (!v) return v.error();
    return add_place(std::string(words[1]), {(*v)[0], (*v)[1]});
  }

  Result<void> add_place(std::string name, const Eigen::Vector2d& p) {
    if (places_.emplace(name, p).second) return {};
    return fail("there is already a place " + in_quotes(name));
  }

  Result<void> read_route(const std::vector<std::string_view>& words) {
    for (std::size_t i = 1; i < words.size(); ++i)
      stops_.push_back({std::string(words[i]), line_number_});
    return {};
  }

  Result<void> read_cell_size(const std::vector<std::string_view>& words) {
    const auto v = numbers(words, 1, 1, "metres_per_character NUMBER");
    if (!v) return v.error();
    if (!((*v)[0] >= 1e-3)) return fail("a character must be at least a millimetre wide");
    mask_.cell_m = (*v)[0];
    return {};
  }

  Result<void> read_picture_line() {
    if (line_.size() > static_cast<std::size_t>(kMaxPictureSide) ||
        picture_.size() >= static_cast<std::size_t>(kMaxPictureSide)) {
      return fail("the picture is larger than 8192 x 8192 characters");
    }
    for (std::size_t i = 0; i < line_.size(); ++i) {
      const char c = line_[i];
      const bool is_place = std::isalnum(static_cast<unsigned char>(c)) != 0;
      if (c == '#' || c == ' ' || c == '.' || is_place) continue;
      return fail("column " + std::to_string(i + 1) +
                  ": the picture has '#' for wall, ' ' or '.' for free space and letters or digits "
                  "for places" +
                  (c == '\t' ? "; this is a tab" : ""));
    }
    picture_.push_back(line_);
    picture_line_numbers_.push_back(line_number_);
    return {};
  }

  Result<void> read_cells() {
    while (!picture_.empty() && picture_.back().find_first_not_of(' ') == std::string_view::npos)
      picture_.pop_back();
    mask_.height = static_cast<int>(picture_.size());
    for (const std::string_view row : picture_)
      mask_.width = std::max(mask_.width, static_cast<int>(row.size()));
    mask_.solid.assign(mask_.index(0, mask_.height), 0);
    for (std::size_t r = 0; r < picture_.size(); ++r) {
      line_number_ = picture_line_numbers_[r];
      for (std::size_t c = 0; c < picture_[r].size(); ++c) {
        const char mark = picture_[r][c];
        if (mark == '#') {
          mask_.solid[mask_.index(static_cast<int>(c), static_cast<int>(r))] = 1;
        } else if (mark != ' ' && mark != '.') {
          const Eigen::Vector2d centre(static_cast<double>(c) + 0.5,
                                       mask_.height - static_cast<double>(r) - 0.5);
          if (auto done = add_place(std::string(1, mark), mask_.cell_m * centre); !done)
            return done.error();
        }
      }
    }
    return {};
  }

  Result<PlannedRoute> finish() {
    if (in_picture_) {
      if (auto done = read_cells(); !done) return done.error();
      if (mask_.height > 0) {
        const auto drawn = FloorPlan::from_cells(mask_);
        if (drawn) walls_.insert(walls_.end(), drawn->segments().begin(), drawn->segments().end());
      }
    }
    auto plan = FloorPlan::from_segments(std::move(walls_));
    if (!plan) return fail_at(0, plan.error().message, ErrorCode::invalid);
    PlannedRoute result{std::move(plan).value(), {}};
    for (const Stop& stop : stops_) {
      const auto place = places_.find(stop.name);
      if (place == places_.end()) {
        return fail_at(
            stop.line,
            "the route names " + in_quotes(stop.name) + ", which is not a place of this plan",
            ErrorCode::not_found);
      }
      result.route_m.push_back(place->second);
    }
    return result;
  }

  std::string_view rest_;
  std::string source_;
  std::string_view line_;
  std::size_t line_number_ = 0;
  bool in_picture_ = false;
  CellMask mask_;
  std::vector<std::string_view> picture_;
  std::vector<std::size_t> picture_line_numbers_;
  std::vector<Segment> walls_;
  std::map<std::string, Eigen::Vector2d> places_;
  std::vector<Stop> stops_;
};

}  // namespace

Result<PlannedRoute> read_plan(std::string_view text, std::string_view source) {
  return Reader(text, source).read();
}

std::string_view demo_building() {
  return R"(# An office floor of 60 m x 30 m: a loop of corridors around an inner block, rooms on both sides
# and a hall with pillars. The route is two rounds, the first into the rooms.
metres_per_character 0.5
route a b c d c b e f g h f e i j k j i l
route m n o p q r q s t u t s v w x w v y z a
route b e i l A p q s v y z a b e
picture
########################################################################################################################
#       ######        #               #           ######    #                       #          ########  #             #
#       ######        #               #           ######    #     ###               #          ########  #             #
#                     #               #           ######    #     ###               #                    #             #
#                     #               #                     #                       #                    #             #
###            d      #               #                     #                       #        k           #             #
###                   #               #                     #                 ####  #                    #             #
###                   #               #                     #                 ####  #                    #             #
###                   # ####          #                     #                 ####  #               ###  #             #
#              c      # ####          #                     #                       #        j      ###  #             #
#                     #               #                     #                       #                    #             #
##############   #############   ###########  ########################   ###################   ###########    ##   ##  #
#                                                 ##                                                     #    ##   ##  #
#                                                                                                                      #
#  a           b                                       e                                     i        l                #
#                                                                                                          m           #
#                                                                                       #                              #
#     ##############  ################################   ###########################################     #             #
#     #                           #                                         #                      #     #             #
#     #                           #                    f                    #                      #     #             #
#     # ###                       #                         h               #             ##       #     #             #
#     # ###                       #                                         #             ##       #     #    ##   ##  #
#     # ###                       #         #                     #         #             ##       #     #    ##   ##  #
#     #                           #                                         #             ##       #     #             #
#     #                           #               g                         #             ##       #     #             #
#     #                           #                                         #             ##       #     #             #
#     #             ########      #                    #                    #                      #     #             #
#     #             ########      #                                         #                      #     #             #
#     #                           #                                         #                      #     #             #
#  z  ##############################################################################################  A  #  n          #
##    #                                           #                                                #     #             #
##    #                                           #         ########                               #     #    ##   ##  #
#     #                                           #         ########                               #     #    ##   ##  #
#     #                                           #                                                #     #             #
#     #                  x                        #                                                #     #             #
#     #                                           #                                                #     #             #
#     #   ###                                     #                                         #####  #     #             #
#     #   ###                                     #                                         #####  #     #             #
#     #   ###                               ####  #                                         #####  #     #             #
#     #   ###                w              ####  #                                                #     #             #
#     #                                     ####  #                                                #     #             #
#     #                                           #                                                #     #    ##   ##  #
#     ######################   #################################################   #################     #    ##   ##  #
#                                                                                                                      #
#                                                                                                                      #
#  y                         v                               s                             q          p    o           #
#                                                                                                                      #
#                                   ##                                                                   #             #
############   #############################################   ###########################   #############             #
#                             #                                         #                                #             #
#                             #                     ##                  #                            ### #             #
#                             #                     ##       t          #                  r         ### #    ##   ##  #
#   ##                        #                     ##                  #                            ### #    ##   ##  #
#   ##                        #                          u              #                            ### #             #
#   ##                        #         ########                        #                                #             #
#   ##                        #         ########                        #       ##########               #             #
#   ##        #########       #                               ######    #       ##########               #             #
#             #########       #                               ######    #                                #             #
#                             #                                         #                                #             #
########################################################################################################################
)";
}

Result<FloorPlan> plan_from_picture(std::span<const std::uint8_t> pixels, int width, int height,
                                    double metres_per_pixel, std::uint8_t wall_below) {
  CellMask mask{width, height, metres_per_pixel, {}};
  mask.solid.reserve(pixels.size());
  for (const std::uint8_t grey : pixels) mask.solid.push_back(grey < wall_below ? 1 : 0);
  return FloorPlan::from_cells(mask);
}

}  // namespace wayfare::sim
