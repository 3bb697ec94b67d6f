// SPDX-License-Identifier: GPL-3.0-or-later
// A stage's options, declared once: flag, unit, range, default and help of a field. The command
// line, the checks, the help text and the parameters in the report all come from that.
//
//   struct NormalsOptions {
//     int neighbours = 16;    ///< of the plane fit
//     double halo_m = 20.0;   ///< read around the tile
//     Beam beam = Beam::kTrajectory;
//   };
//   std::vector<Option> describe(NormalsOptions& o) {
//     return {Option("neighbours", o.neighbours, "neighbours of the plane fit").range(6, 64),
//             Option("halo-m", o.halo_m, "border read around the tile").range(0, 500).unit("m"),
//             Option("beam", o.beam, {{"trajectory", Beam::kTrajectory}, {"vertical",
//                    Beam::kVertical}}, "what orients the normals")};
//   }
//
// The default is what the field holds when its Option is made. An Option refers to its field: the
// options struct must outlive it and stay where it is.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace cornice {

class Option {
 public:
  /// One of several names; get() is the present one's index.
  struct Choice {
    std::vector<std::string> names;
    std::function<std::size_t()> get;
    std::function<void(std::size_t)> set;
  };
  /// bool: a flag without value, `--NAME`; `--no-NAME` where the default is true.
  /// Lists of numbers and words: one argument, separated by commas; list of paths: one or more
  /// arguments up to the next flag.
  using Field =
      std::variant<bool*, int*, std::uint64_t*, float*, double*, std::optional<double>*,
                   std::string*, std::filesystem::path*, std::vector<int>*, std::vector<double>*,
                   std::vector<std::string>*, std::vector<std::filesystem::path>*, Choice>;

  /// name: kebab-case with its unit, "halo-m"; the flag is --halo-m. help: what it does and costs,
  /// without full stop.
  template <class T>
  requires std::constructible_from<Field, T*> Option(std::string name, T& field, std::string help)
      : Option(std::move(name), Field(&field), std::move(help)) {}
  template <class Enum>
  requires std::is_enum_v<Enum> Option(std::string name, Enum& field,
                                       const std::vector<std::pair<std::string, Enum>>& values,
                                       std::string help)
      : Option(std::move(name), Field(choice_of(field, values)), std::move(help)) {}

  /// Accepted values, both ends included; for lists, of every entry. Numbers are always finite.
  Option& range(double low, double high);
  Option& at_least(double low);
  Option& above(double low);  ///< low itself is refused
  Option& unit(std::string text);
  Option& short_flag(char letter);
  Option& positional();  ///< an argument without flag, shown as NAME
  Option& required();
  Option& output();            ///< a file or folder to write; see check_output() in stage.h
  Option& group(std::string);  ///< heading in the help text
  Option& advanced();          ///< shown by --help-all only
  Option& ending(
      std::string accepted);  ///< for a path: what its name ends in, ".ply", if it is given
  Option& words(std::vector<std::string> accepted);  ///< for a string: the values it may have

  const std::string& name() const { return name_; }
  const std::string& help() const { return help_; }
  const std::string& unit() const { return unit_; }
  const std::string& group() const { return group_; }
  const std::string& default_text() const { return default_text_; }
  const Field& field() const { return field_; }
  char short_flag() const { return short_flag_; }
  bool is_positional() const { return positional_; }
  bool is_required() const { return required_; }
  bool is_output() const { return output_; }
  bool is_advanced() const { return advanced_; }
  bool is_flag() const { return std::holds_alternative<bool*>(field_); }
  bool takes_many() const;  ///< a list of paths

  /// "--halo-m", "--no-trim" (a flag that is on by default), or "TILE" for a positional one.
  std::string title() const;
  /// "NUMBER", "FILE...", "trajectory|vertical"; empty for a flag.
  std::string type_text() const;
  /// "[0, 500] m", "above 0", "any number of at least 0"; empty where everything goes.
  std::string range_text() const;
  /// The present value as the user would write it.
  std::string value_text() const;

  /// Sets the field from the words given on the command line (one; several for a list of paths;
  /// none for a flag). Throws UsageError naming the option, the word and what is accepted.
  void parse(const std::vector<std::string>& words);
  /// What is wrong with the present value, "must be in [0, 500] m, but is 900"; nothing where it is
  /// accepted. Also for structs filled by code rather than by the command line.
  std::optional<std::string> broken_rule() const;

 private:
  Option(std::string name, Field field, std::string help);
  template <class Enum>
  static Choice choice_of(Enum& field, const std::vector<std::pair<std::string, Enum>>& values);

  std::string name_;
  Field field_;
  std::string help_;
  std::string default_text_;
  std::string unit_;
  std::string group_;
  std::vector<std::string> words_;
  std::optional<double> low_;
  std::optional<double> high_;
  bool low_open_ = false;
  char short_flag_ = '\0';
  bool positional_ = false;
  std::string ending_;
  bool required_ = false;
  bool output_ = false;
  bool advanced_ = false;
  bool on_by_default_ = false;
};

/// First broken rule of all, with the option's full name: "--halo-m: must be in ..., but is ...".
std::optional<std::string> first_broken_rule(const std::vector<Option>& options);

/// Throws UsageError for the first broken rule.
void check_options(const std::vector<Option>& options);

/// `word`'s nearest neighbours among `known` by edit distance, nearest first, at most three; empty
/// where none is near.
std::vector<std::string> nearest_names(const std::string& word,
                                       const std::vector<std::string>& known);

/// ", did you mean A or B?" of nearest_names, or empty.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

template <class Enum>
Option::Choice Option::choice_of(Enum& field,
                                 const std::vector<std::pair<std::string, Enum>>& values) {
  Choice choice;
  std::vector<Enum> entries;
  for (const auto& [name, value] : values) {
    choice.names.push_back(name);
    entries.push_back(value);
  }
  choice.get = [&field, entries] {
    std::size_t i = 0;
    while (i < entries.size() && entries[i] != field) ++i;
    return i;
  };
  choice.set = [&field, entries](std::size_t i) { field = entries[i]; };
  return choice;
}

}  // namespace cornice
