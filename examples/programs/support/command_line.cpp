#include "command_line.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <sstream>
#include <type_traits>
#include <utility>

#include <CLI/CLI.hpp>

namespace wayfare::examples {
namespace {

constexpr int kBadData = 1, kBadUse = 2, kInDoubt = 3;
constexpr const char* kCommandLine = "command line";

std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", number);
  return text;
}

std::string joined(const std::vector<std::string>& words, char between) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += between;
    text += word;
  }
  return text;
}

/// Thrown as an error of its own kind: what is wrong is the file, not the use.
CLI::Validator existing(bool folder) {
  return CLI::Validator(
      [folder](std::string& path) -> std::string {
        namespace fs = std::filesystem;
        std::error_code code;
        const fs::file_status status = fs::status(path, code);
        if (!fs::exists(status)) throw CLI::FileError(path + ": does not exist");
        if (fs::is_directory(status) != folder)
          throw CLI::FileError(path + (folder ? ": is not a folder" : ": is a folder"));
        return {};
      },
      "");
}

/// CLI11 would print limits with six decimals, and the largest number where there is none.
template <class Number>
CLI::Validator within(Number low, Number high, const std::string& must) {
  return CLI::Validator(
      [=](const std::string& text) -> std::string {
        Number value{};
        if (!CLI::detail::lexical_cast(text, value))
          return "must be a" + std::string(std::is_integral_v<Number> ? " whole" : "") +
                 " number, is " + text;
        return value >= low && value <= high ? std::string() : must + ", is " + text;
      },
      "");
}

constexpr const char* kNotNegative = "must not be negative";

template <class Value>
struct Element {
  using Type = Value;
};
template <class Value>
struct Element<std::optional<Value>> : Element<Value> {};
template <class Value>
struct Element<std::vector<Value>> : Element<Value> {};

template <class Value>
std::string value_name() {
  using Type = typename Element<Value>::Type;
  std::string name = "TEXT";
  if constexpr (std::is_floating_point_v<Type>) name = "NUMBER";
  if constexpr (std::is_integral_v<Type>) name = "INTEGER";
  if constexpr (std::is_same_v<Type, std::pair<double, double>>) name = "NUMBER NUMBER";
  constexpr bool kSeveral =
      !std::is_same_v<Value, Type> && !std::is_same_v<Value, std::optional<Type>>;
  return kSeveral ? name + "..." : name;
}

std::string without_dots(std::string value) {
  if (value.ends_with("...")) value.resize(value.size() - 3);
  return value;
}

int print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  return 0;
}

/// Prints what is wrong; returns `code`.
int refuse(const char* program, const std::string& message, int code) {
  std::fprintf(stderr, "%s: %s\n", program, message.c_str());
  if (code == kBadUse) std::fprintf(stderr, "%s --help lists the arguments.\n", program);
  return code;
}

}  // namespace

Option& Option::shown_as(const std::string& value) { return help_->value = value, *this; }
Option& Option::required() { return help_->required = true, option_->required(), *this; }
Option& Option::show_default() {
  option_->capture_default_str();
  return help_->initial = option_->get_default_str(), *this;
}
Option& Option::range(int low, int high) {
  help_->conditions.push_back(std::to_string(low) + " to " + std::to_string(high));
  return option_->check(within(low, high, "must be from " + help_->conditions.back())), *this;
}
Option& Option::range(double low, double high) {
  help_->conditions.push_back(text_of(low) + " to " + text_of(high));
  return option_->check(within(low, high, "must be from " + help_->conditions.back())), *this;
}
Option& Option::positive() {
  using Limits = std::numeric_limits<double>;
  help_->conditions.emplace_back("positive");
  return option_->check(within(Limits::min(), Limits::max(), "must be positive")), *this;
}
Option& Option::not_negative() {
  help_->conditions.emplace_back("not negative");
  return option_->check(within(0.0, std::numeric_limits<double>::max(), kNotNegative)), *this;
}
Option& Option::existing_file() {
  help_->value = help_->value.ends_with("...") ? "FILE..." : "FILE";
  return option_->check(existing(false)), *this;
}
Option& Option::existing_folder() {
  help_->value = help_->value.ends_with("...") ? "DIR..." : "DIR";
  return option_->check(existing(true)), *this;
}
Option& Option::one_of(const std::vector<std::string>& words) {
  constexpr std::size_t kShort = 24;
  const std::string all = joined(words, '|');
  help_->choices = words;
  help_->value = all.size() <= kShort ? all : "WORD";
  return option_->check(CLI::IsMember(words)), *this;
}
Option& Option::expected(int count) {
  std::string one = without_dots(help_->value);
  char between = ' ';
  if (one.ends_with(',')) {
    between = ',';
    one.pop_back();
  }
  help_->value = joined(std::vector<std::string>(static_cast<std::size_t>(count), one), between);
  return option_->expected(count), *this;
}
Option& Option::expected(int least, int most) {
  help_->value = without_dots(help_->value) + "...";
  help_->conditions.push_back(std::to_string(least) + " to " + std::to_string(most) + " values");
  return option_->expected(least, most), *this;
}
Option& Option::delimiter(char between) {
  help_->value = without_dots(help_->value) + between + "...";
  return option_->delimiter(between), *this;
}
Option& Option::take_all() { return option_->take_all(), *this; }
Option& Option::needs(const std::string& other) {
  help_->conditions.push_back("with " + other);
  return option_->needs(other), *this;
}
Option& Option::excludes(const std::string& other) {
  help_->conditions.push_back("not with " + other);
  return option_->excludes(other), *this;
}
bool Option::given() const { return option_->count() > 0; }
std::string Option::name() const { return option_->get_name(); }

CommandLine::CommandLine(const std::string& description)
    : app_(std::make_unique<CLI::App>(description)) {
  help_.description = description;
  app_->set_help_flag();  // parse() looks for it, and for the other forms of the help
  help_.options.push_back({{"-h", "--help"}, "", "print this help and exit"});
  help_.options.push_back({{"--version"}, "", "print the version and exit"});
  help_.options.push_back({{"--man-page"}, "", "print this help as a man page and exit"});
  help_.options.push_back({{"--bash-completion"}, "", "print a completion for bash and exit"});
}
CommandLine::~CommandLine() = default;

Option CommandLine::add(CLI::Option* option, const std::string& name, std::string value,
                        const std::string& help) {
  OptionHelp entry{{}, std::move(value), help};
  std::istringstream names(name);
  for (std::string one; std::getline(names, one, ',');) entry.names.push_back(one);
  entry.positional = !name.starts_with('-');
  help_.options.push_back(std::move(entry));
  return {option, &help_.options.back()};
}

template <class Value>
Option CommandLine::add_option(const std::string& name, Value& value, const std::string& help) {
  CLI::Option* option = app_->add_option(name, value, help);
  // CLI11 reads -1 as the largest number without a sign.
  if constexpr (std::is_unsigned_v<typename Element<Value>::Type>)
    option->check(CLI::Validator(
        [](const std::string& text) {
          return text.starts_with('-') ? kNotNegative + (", is " + text) : std::string();
        },
        ""));
  return add(option, name, value_name<Value>(), help);
}

using Text = const std::string&;
template Option CommandLine::add_option(Text, int&, Text);
template Option CommandLine::add_option(Text, unsigned&, Text);
template Option CommandLine::add_option(Text, double&, Text);
template Option CommandLine::add_option(Text, std::size_t&, Text);
template Option CommandLine::add_option(Text, std::uint16_t&, Text);
template Option CommandLine::add_option(Text, std::string&, Text);
template Option CommandLine::add_option(Text, std::optional<double>&, Text);
template Option CommandLine::add_option(Text, std::vector<int>&, Text);
template Option CommandLine::add_option(Text, std::vector<double>&, Text);
template Option CommandLine::add_option(Text, std::vector<std::string>&, Text);
template Option CommandLine::add_option(Text, std::vector<std::pair<double, double>>&, Text);

Option CommandLine::add_flag(const std::string& name, bool& value, const std::string& help) {
  return add(app_->add_flag(name, value, help), name, "", help);
}

Option CommandLine::add_word(const std::string& name, const std::string& help,
                             const std::function<void(const std::string&)>& take) {
  return add(app_->add_option_function<std::string>(name, take, help), name, "TEXT", help);
}

Option CommandLine::add_print(const std::string& name, const std::function<std::string()>& text,
                              const std::string& help) {
  const auto print_and_end = [text] {
    print(text());
    throw CLI::Success();
  };
  return add(app_->add_flag_callback(name, print_and_end, help), name, "", help);
}

void CommandLine::footer(const std::string& text) { help_.more = text; }

void CommandLine::example(const std::string& arguments, const std::string& task) {
  help_.examples.push_back({arguments, task});
}

/// The first on the command line, with the known one that it may mean; empty without one.
std::string CommandLine::unknown_option() const {
  std::vector<std::string> known;
  for (const OptionHelp& option : help_.options)
    if (!option.positional) known.insert(known.end(), option.names.begin(), option.names.end());
  for (const std::string& word : app_->remaining()) {
    if (!word.starts_with('-')) continue;
    const std::string name = word.substr(0, word.find('='));
    const std::string meant = nearest(name, known);
    return "unknown option " + name + (meant.empty() ? "" : "; did you mean " + meant + "?");
  }
  return {};
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
  help_.name = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "";
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string_view word = argv[i];
    if (word == "--help" || word == "-h") return print(to_help(help_));
    if (word == "--version") return print(help_.name + " " WAYFARE_VERSION "\n");
    if (word == "--man-page") return print(to_man_page(help_, WAYFARE_VERSION));
    if (word == "--bash-completion") return print(to_bash_completion(help_));
  }
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success&) {
    return 0;
  } catch (const CLI::ParseError& error) {
    const std::string unknown = unknown_option();
    const char* name = help_.name.c_str();
    if (!unknown.empty()) return refuse(name, unknown, kBadUse);
    const bool is_data = error.get_exit_code() == static_cast<int>(CLI::ExitCodes::FileError);
    return refuse(name, error.what(), is_data ? kBadData : kBadUse);
  }
  return std::nullopt;
}

Error bad_use(const std::string& message) { return {ErrorCode::invalid, message, kCommandLine}; }

int exit_code(const char* program, const Error& error) {
  const bool is_use = error.source == kCommandLine;
  return is_use ? refuse(program, error.message, kBadUse)
                : refuse(program, error.to_string(), kBadData);
}

int exit_code(const char* program, const Result<void>& done) {
  return done ? 0 : exit_code(program, done.error());
}

int exit_code(const char* program, const Result<Doubt>& done) {
  if (!done) return exit_code(program, done.error());
  if (done->why.empty()) return 0;
  std::fprintf(stderr, "%s: in doubt: %s\n", program, done->why.c_str());
  return kInDoubt;
}

}  // namespace wayfare::examples
