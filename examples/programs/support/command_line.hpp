#pragma once

// The options of a program's command line, its help and its exit codes. CLI11 is compiled once, in
// command_line.cpp.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>

#include "help_text.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace wayfare::examples {

/// An argument of a program. Calls can be chained.
class Option {
 public:
  Option(CLI::Option* option, OptionHelp* help) : option_(option), help_(help) {}

  /// What --help and completions call its value: FILE, DIR, NAME …
  Option& shown_as(const std::string& value);
  Option& required();
  Option& show_default();  ///< in --help
  /// [low, high], both included.
  Option& range(int low, int high);
  Option& range(double low, double high);
  Option& positive();
  Option& not_negative();
  Option& existing_file();  ///< exit code 1 if it is not there
  Option& existing_folder();
  Option& one_of(const std::vector<std::string>& words);
  /// Number of values, for a variable that takes several.
  Option& expected(int count);
  Option& expected(int least, int most);
  Option& delimiter(char between);  ///< between values in one word
  Option& take_all();               ///< may be given repeatedly
  /// Of another option, by its name.
  Option& needs(const std::string& other);
  Option& excludes(const std::string& other);

  /// Whether it was on the command line.
  [[nodiscard]] bool given() const;
  [[nodiscard]] std::string name() const;

 private:
  CLI::Option* option_;
  OptionHelp* help_;
};

/// The arguments of a program: each option writes to a variable that outlives the parsing and whose
/// value before it is the default. Names are "--long" options or positional arguments ("LOG").
class CommandLine {
 public:
  /// The first sentence of the description is the summary of the man page. Lines are wrapped.
  explicit CommandLine(const std::string& description);
  ~CommandLine();

  /// For the types instantiated in command_line.cpp: numbers, strings, vectors and optionals of
  /// them.
  template <class Value>
  Option add_option(const std::string& name, Value& value, const std::string& help);
  /// The path of an existing file, or several.
  template <class Path>
  Option add_file(const std::string& name, Path& path, const std::string& help) {
    return add_option(name, path, help).existing_file();
  }
  /// A number in [low, high]; --help shows its default.
  template <class Value, class Bound>
  Option add_number(const std::string& name, Value& value, Bound low, Bound high,
                    const std::string& help) {
    return add_option(name, value, help).range(low, high).show_default();
  }
  /// A positive number; --help shows its default.
  Option add_positive(const std::string& name, double& value, const std::string& help) {
    return add_option(name, value, help).positive().show_default();
  }
  Option add_flag(const std::string& name, bool& value, const std::string& help);
  /// One of the words of `choices`, with the value it stands for.
  template <class Value>
  Option add_choice(const std::string& name, Value& value,
                    const std::map<std::string, Value>& choices, const std::string& help) {
    std::vector<std::string> words;
    words.reserve(choices.size());
    for (const auto& choice : choices) words.push_back(choice.first);
    return add_word(name, help,
                    [&value, choices](const std::string& word) { value = choices.at(word); })
        .one_of(words);
  }
  /// A word that `take` receives.
  Option add_word(const std::string& name, const std::string& help,
                  const std::function<void(const std::string&)>& take);
  /// A flag that prints a text and ends the program.
  Option add_print(const std::string& name, const std::function<std::string()>& text,
                   const std::string& help);
  /// What --help says after the options. Lines that begin with a space are not wrapped.
  void footer(const std::string& text);
  /// A call for a task, at the end of --help; arguments without the program's name.
  void example(const std::string& arguments, const std::string& task);

  /// Returns the exit code if the program is to end: after --help, --version, --man-page and
  /// --bash-completion, or after a wrong argument, which is reported on standard error, an unknown
  /// option with the nearest known one.
  [[nodiscard]] std::optional<int> parse(int argc, char** argv);

 private:
  Option add(CLI::Option* option, const std::string& name, std::string value,
             const std::string& help);
  [[nodiscard]] std::string unknown_option() const;

  std::unique_ptr<CLI::App> app_;
  ProgramHelp help_;
};

/// Arguments that are wrong together, or a value that only the program can check: exit code 2.
[[nodiscard]] Error bad_use(const std::string& message);

/// Why a result that was written is in doubt; empty: it is not.
struct Doubt {
  std::string why;

  /// Another reason.
  void add(const std::string& reason) { why += (why.empty() ? "" : "; ") + reason; }
};

/// 1 for an error and 2 for bad_use(), which are printed on standard error.
int exit_code(const char* program, const Error& error);
/// The same, and 0 for a success. The exit codes are in every --help.
int exit_code(const char* program, const Result<void>& done);
/// The same, and 3 for a doubt, which is printed too.
int exit_code(const char* program, const Result<Doubt>& done);

}  // namespace wayfare::examples
