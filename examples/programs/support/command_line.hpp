#pragma once

// What a program may be told on its command line. CLI11 does the work, compiled once.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace wayfare::examples {

/// An argument of a program. Each call says more of it and gives it back for the next.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option& required();
  Option& show_default();  ///< in --help
  /// The value lies in [low, high].
  Option& range(int low, int high);
  Option& range(double low, double high);
  Option& positive();
  Option& not_negative();
  Option& existing_file();
  Option& existing_folder();
  Option& one_of(const std::vector<std::string>& words);
  /// So many values, for a variable that takes several.
  Option& expected(int count);
  Option& expected(int least, int most);
  Option& delimiter(char between);  ///< of values in one word
  Option& take_all();               ///< may be given again and again
  /// Another option, by its name.
  Option& needs(const std::string& other);
  Option& excludes(const std::string& other);

 private:
  CLI::Option* option_;
};

/// The arguments of a program: each option writes into a variable that outlives the parsing, whose
/// value before it is the default. Names are "--long" options or positions ("LOG").
class CommandLine {
 public:
  explicit CommandLine(const std::string& description);
  ~CommandLine();

  /// Of the types command_line.cpp lists: numbers, text, and several or none of them.
  template <class Value>
  Option add_option(const std::string& name, Value& value, const std::string& help);
  Option add_flag(const std::string& name, bool& value, const std::string& help);
  /// One of the words of `choices`, which stands for its value.
  template <class Value>
  Option add_choice(const std::string& name, Value& value,
                    const std::map<std::string, Value>& choices, const std::string& help) {
    std::vector<std::string> words;
    for (const auto& choice : choices) words.push_back(choice.first);
    return add_word(name, help,
                    [&value, choices](const std::string& word) { value = choices.at(word); })
        .one_of(words);
  }
  /// A flag that prints something and ends the program.
  Option add_print(const std::string& name, const std::function<std::string()>& text,
                   const std::string& help);
  void footer(const std::string& text);

  /// Reads the arguments. The exit code where the program is to end: after --help, or where an
  /// argument is wrong, which has then been said on standard error.
  [[nodiscard]] std::optional<int> parse(int argc, char** argv);

 private:
  Option add_word(const std::string& name, const std::string& help,
                  const std::function<void(const std::string&)>& take);

  std::unique_ptr<CLI::App> app_;
};

}  // namespace wayfare::examples
