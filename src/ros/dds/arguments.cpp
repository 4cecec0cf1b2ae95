#include "ros/dds/arguments.hpp"

#include <algorithm>
#include <optional>
#include <sstream>

#include <wayfare/io/text_file.hpp>

namespace wayfare::ros::dds {
namespace {

using Pair = std::pair<std::string, std::string>;

Error invalid(std::string text, std::string what) {
  return {ErrorCode::invalid, std::move(text), std::move(what)};
}

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == text.npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") + 1 - first));
}

/// A plain value of YAML without its quotes.
std::string plain(std::string_view value) {
  std::string text = trimmed(value);
  const bool quoted = text.size() >= 2 && (text.front() == '"' || text.front() == '\'') &&
                      text.back() == text.front();
  return quoted ? text.substr(1, text.size() - 2) : text;
}

void set(std::vector<Pair>& parameters, const std::string& name, std::string value) {
  for (Pair& p : parameters)
    if (p.first == name) return void(p.second = std::move(value));
  parameters.emplace_back(name, std::move(value));
}

/// `from:=to`, or with `node:` before it only if that is this node.
Result<std::optional<Pair>> assignment(const std::string& text, const std::string& node) {
  const std::size_t at = text.find(":=");
  if (at == text.npos || at == 0) return invalid("is not NAME:=VALUE", text);
  std::string from = text.substr(0, at);
  if (const std::size_t colon = from.find(':'); colon != from.npos) {
    if (from.substr(0, colon) != node) return std::optional<Pair>();
    from.erase(0, colon + 1);
  }
  return std::optional(Pair(from, text.substr(at + 2)));
}

/// Whether a key of a parameter file is for this node.
bool is_for(std::string_view key, const NodeName& node) {
  const std::string full = (node.ns == "/" ? "" : node.ns) + "/" + node.name;
  return key == "/**" || key == node.name || key == full || key == "/**/" + node.name;
}

/// One line of a parameter file: depth by its indentation, key and value.
struct Line {
  std::size_t indent = 0;
  std::string key, value;
};

/// Nothing for comments and empty lines.
Result<std::optional<Line>> line_of(std::string_view text, const std::string& place) {
  if (const std::size_t comment = text.find(" #"); comment != text.npos)
    text = text.substr(0, comment);
  const std::string content = trimmed(text);
  if (content.empty() || content.front() == '#' || content == "---") return std::optional<Line>();
  const std::size_t colon = content.find(": ") != content.npos ? content.find(": ")
                            : content.ends_with(':')           ? content.size() - 1
                                                               : content.npos;
  const std::string value = colon == content.npos ? "" : trimmed(content.substr(colon + 1));
  const bool structured = value.find_first_of("{&*|>") == 0;
  if (colon == content.npos || structured || text.find('\t') < text.find(content.front()))
    return Error{ErrorCode::parse, "is not 'name: value' with a plain value", place};
  return std::optional(
      Line{text.find_first_not_of(' '), plain(content.substr(0, colon)), plain(value)});
}

/// `NODE: ros__parameters: name: value`, nested names joined by dots.
Result<void> read_parameters(const std::string& path, const NodeName& node,
                             std::vector<Pair>& parameters) {
  const auto file = io::read_file(path);
  if (!file) return file.error();
  std::istringstream lines(file->bytes);
  std::vector<Line> above;
  std::size_t number = 0;
  for (std::string text; std::getline(lines, text);) {
    const auto line = line_of(text, path + ":" + std::to_string(++number));
    if (!line) return line.error();
    if (!*line) continue;
    while (!above.empty() && above.back().indent >= (*line)->indent) above.pop_back();
    above.push_back(**line);
    if (above.size() < 3 || (*line)->value.empty()) continue;
    const auto begin = std::find_if(above.begin(), above.end(),
                                    [](const Line& l) { return l.key == "ros__parameters"; });
    std::string full;
    for (auto l = above.begin(); l != begin && l != above.end(); ++l)
      full += (full.empty() || l->key.starts_with('/') ? "" : "/") + l->key;
    if (begin == above.end() || !is_for(full, node)) continue;
    std::string name;
    for (auto l = begin + 1; l != above.end(); ++l) name += (name.empty() ? "" : ".") + l->key;
    set(parameters, name, (*line)->value);
  }
  return {};
}

/// The words between --ros-args and --, taken from the arguments.
std::vector<std::string> take_words(std::vector<std::string>& arguments) {
  std::vector<std::string> words, others;
  bool ours = false;
  for (std::string& a : arguments) {
    if (a == "--ros-args") {
      ours = true;
    } else if (ours && a == "--") {
      ours = false;
    } else {
      (ours ? words : others).push_back(std::move(a));
    }
  }
  arguments = std::move(others);
  return words;
}

Result<void> set_namespace(NodeName& node, std::string ns) {
  if (!ns.starts_with('/')) ns.insert(0, "/");
  if (ns != "/")
    if (const auto ok = absolute(ns, node); !ok) return ok.error();
  node.ns = std::move(ns);
  return {};
}

}  // namespace

Result<RosArguments> take_ros_arguments(std::vector<std::string>& arguments,
                                        const std::string& name) {
  RosArguments all{{name}};
  std::vector<Pair> given;
  std::vector<std::string> files;
  const auto words = take_words(arguments);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--enable-rosout-logs" || word == "--disable-rosout-logs" ||
        word == "--enable-stdout-logs" || word == "--disable-stdout-logs" ||
        word == "--enable-external-lib-logs" || word == "--disable-external-lib-logs")
      continue;
    if (++i == words.size()) return invalid("needs a value", word);
    if (word == "--params-file") {
      files.push_back(words[i]);
    } else if (word == "-r" || word == "--remap" || word == "-p" || word == "--param") {
      const auto pair = assignment(words[i], name);
      if (!pair) return pair.error();
      if (!*pair) continue;
      auto& [from, to] = const_cast<Pair&>(**pair);
      if (word == "-p" || word == "--param") {
        set(given, from, plain(to));
      } else if (from == "__node" || from == "__name") {
        if (!is_token(to)) return invalid("is no name of a node", to);
        all.node.name = to;
      } else if (from == "__ns") {
        if (const auto ok = set_namespace(all.node, to); !ok) return ok.error();
      } else {
        all.remappings.emplace_back(from, to);
      }
    } else if (word != "--log-level" && word != "--log-config-file" && word != "-e" &&
               word != "--enclave" && word != "--log-file-name") {
      return invalid("is no argument of ROS 2", word);
    }
  }
  for (const auto& file : files)
    if (const auto ok = read_parameters(file, all.node, all.parameters); !ok) return ok.error();
  for (auto& [parameter, value] : given) set(all.parameters, parameter, std::move(value));
  for (const auto& [from, to] : all.remappings)
    for (const std::string& topic : {from, to})
      if (const auto ok = absolute(topic, all.node); !ok) return ok.error();
  return all;
}

Result<std::string> RosArguments::topic(std::string_view name) const {
  auto full = absolute(name, node);
  if (!full) return full;
  for (const auto& [from, to] : remappings)
    if (*absolute(from, node) == *full) return absolute(to, node);
  return full;
}

std::string RosArguments::parameter(std::string_view name) const {
  for (const auto& [key, value] : parameters)
    if (key == name) return value;
  return "";
}

}  // namespace wayfare::ros::dds
