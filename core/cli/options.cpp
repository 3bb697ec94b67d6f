// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/options.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <type_traits>

#include "core/base/error.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

template <class... F>
struct Overload : F... {
  using F::operator()...;
};
template <class... F>
Overload(F...) -> Overload<F...>;

template <class T>
std::string number_text(T value) {
  char text[64];
  std::to_chars_result written{};
  if constexpr (std::is_floating_point_v<T>) {
    // Shortest text that reads back the same, but 100000 rather than 1e+05.
    const double size = std::abs(static_cast<double>(value));
    const bool plain = size < 1e15 && (size == 0.0 || size >= 1e-4);
    written = std::to_chars(text, text + sizeof text, value,
                            plain ? std::chars_format::fixed : std::chars_format::general);
  } else {
    written = std::to_chars(text, text + sizeof text, value);
  }
  return written.ec == std::errc() ? std::string(text, written.ptr) : std::string("?");
}

/// A whole word as a number; nothing for trailing text ("3m"), NaN, infinity or overflow.
template <class T>
std::optional<T> number_from(const std::string& word) {
  const char* first = word.data();
  const char* last = first + word.size();
  // from_chars takes no plus sign, people do write one.
  if (first + 1 < last && *first == '+' && *(first + 1) != '-') ++first;
  T value{};
  const auto [end, error] = std::from_chars(first, last, value);
  if (error != std::errc() || end != last || first == last) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t comma = text.find(','); comma != std::string::npos;
       comma = text.find(',', begin)) {
    parts.push_back(text.substr(begin, comma - begin));
    begin = comma + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

std::string joined(const std::vector<std::string>& parts, const std::string& separator) {
  std::string all;
  for (const std::string& part : parts) all += (&part == parts.data() ? "" : separator) + part;
  return all;
}

template <class T, class ToText>
std::string list_text(const std::vector<T>& values, const ToText& to_text) {
  std::vector<std::string> parts;
  for (const T& value : values) parts.push_back(to_text(value));
  return joined(parts, ",");
}

/// Every number the field holds, for the range check.
std::vector<double> numbers_of(const Option::Field& field) {
  return std::visit(
      [](const auto& pointer) -> std::vector<double> {
        using Target = std::decay_t<decltype(pointer)>;
        if constexpr (std::is_same_v<Target, std::optional<double>*>) {
          return *pointer ? std::vector<double>{**pointer} : std::vector<double>{};
        } else if constexpr (std::is_same_v<Target, std::vector<int>*> ||
                             std::is_same_v<Target, std::vector<double>*>) {
          return {pointer->begin(), pointer->end()};
        } else if constexpr (std::is_arithmetic_v<std::remove_pointer_t<Target>>) {
          return {static_cast<double>(*pointer)};
        } else {
          return {};
        }
      },
      field);
}

/// True where no value has been given and none is there by default.
bool is_unset(const Option::Field& field) {
  return std::visit(
      [](const auto& pointer) {
        using Target = std::decay_t<decltype(pointer)>;
        if constexpr (std::is_same_v<Target, std::optional<double>*>) {
          return !pointer->has_value();
        } else if constexpr (requires { pointer->empty(); }) {
          return pointer->empty();
        } else {
          return false;
        }
      },
      field);
}

}  // namespace

Option::Option(std::string name, Field field, std::string help)
    : name_(std::move(name)), field_(std::move(field)), help_(std::move(help)) {
  default_text_ = value_text();
  on_by_default_ = is_flag() && *std::get<bool*>(field_);
}

Option& Option::range(double low, double high) {
  assert(low <= high && "a range from low to high");
  low_ = low;
  high_ = high;
  return *this;
}
Option& Option::at_least(double low) {
  low_ = low;
  return *this;
}
Option& Option::above(double low) {
  low_ = low;
  low_open_ = true;
  return *this;
}
Option& Option::unit(std::string text) {
  unit_ = std::move(text);
  return *this;
}
Option& Option::short_flag(char letter) {
  short_flag_ = letter;
  return *this;
}
Option& Option::positional() {
  positional_ = true;
  return *this;
}
Option& Option::required() {
  required_ = true;
  return *this;
}
Option& Option::output() {
  assert(std::holds_alternative<fs::path*>(field_) && "an output is a path");
  output_ = true;
  return *this;
}
Option& Option::group(std::string title) {
  group_ = std::move(title);
  return *this;
}
Option& Option::advanced() {
  advanced_ = true;
  return *this;
}
Option& Option::ending(std::string accepted) {
  assert(std::holds_alternative<fs::path*>(field_) && "an ending is for a path");
  ending_ = std::move(accepted);
  return *this;
}

Option& Option::words(std::vector<std::string> accepted) {
  assert(std::holds_alternative<std::string*>(field_) && "words are for a string");
  words_ = std::move(accepted);
  return *this;
}

bool Option::takes_many() const { return std::holds_alternative<std::vector<fs::path>*>(field_); }

std::string Option::title() const {
  if (positional_) return name_;
  return (on_by_default_ ? "--no-" : "--") + name_;
}

std::string Option::type_text() const {
  if (!words_.empty()) return joined(words_, "|");
  return std::visit(
      Overload{[](const bool*) { return std::string(); },
               [](const int*) { return std::string("INTEGER"); },
               [](const std::uint64_t*) { return std::string("INTEGER"); },
               [](const float*) { return std::string("NUMBER"); },
               [](const double*) { return std::string("NUMBER"); },
               [](const std::optional<double>*) { return std::string("NUMBER"); },
               [](const std::string*) { return std::string("TEXT"); },
               [](const fs::path*) { return std::string("PATH"); },
               [](const std::vector<int>*) { return std::string("INTEGER,..."); },
               [](const std::vector<double>*) { return std::string("NUMBER,..."); },
               [](const std::vector<std::string>*) { return std::string("TEXT,..."); },
               [](const std::vector<fs::path>*) { return std::string("PATH..."); },
               [](const Choice& choice) { return joined(choice.names, "|"); }},
      field_);
}

std::string Option::range_text() const {
  std::string text;
  if (low_ && high_) {
    text =
        std::string(low_open_ ? "]" : "[") + number_text(*low_) + ", " + number_text(*high_) + "]";
  } else if (low_) {
    text = (low_open_ ? "above " : "at least ") + number_text(*low_);
  }
  return text.empty() || unit_.empty() ? text : text + " " + unit_;
}

std::string Option::value_text() const {
  return std::visit(
      Overload{[](const bool* v) { return std::string(*v ? "on" : "off"); },
               [](const int* v) { return number_text(*v); },
               [](const std::uint64_t* v) { return number_text(*v); },
               [](const float* v) { return number_text(*v); },
               [](const double* v) { return number_text(*v); },
               [](const std::optional<double>* v) { return *v ? number_text(**v) : std::string(); },
               [](const std::string* v) { return *v; },
               [](const fs::path* v) { return v->string(); },
               [](const std::vector<int>* v) { return list_text(*v, number_text<int>); },
               [](const std::vector<double>* v) { return list_text(*v, number_text<double>); },
               [](const std::vector<std::string>* v) { return joined(*v, ","); },
               [](const std::vector<fs::path>* v) {
                 return list_text(*v, [](const fs::path& path) { return path.string(); });
               },
               [](const Choice& choice) {
                 const std::size_t i = choice.get();
                 return i < choice.names.size() ? choice.names[i] : std::string();
               }},
      field_);
}

namespace {

/// Sets a field from its words; false where they are not of its type.
struct FieldParser {
  const std::vector<std::string>& words;

  bool operator()(bool*) const { return false; }
  template <class T>
  requires std::is_arithmetic_v<T>
  bool operator()(T* field) const {
    const std::optional<T> value = number_from<T>(words.back());
    if (value) *field = *value;
    return value.has_value();
  }
  bool operator()(std::optional<double>* field) const {
    const std::optional<double> value = number_from<double>(words.back());
    if (value) *field = value;
    return value.has_value();
  }
  bool operator()(std::string* field) const {
    *field = words.back();
    return true;
  }
  bool operator()(fs::path* field) const {
    *field = words.back();
    return !words.back().empty();
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  bool operator()(std::vector<T>* field) const {
    std::vector<T> values;
    for (const std::string& part : split_at_commas(words.back())) {
      const std::optional<T> value = number_from<T>(part);
      if (!value) return false;
      values.push_back(*value);
    }
    *field = std::move(values);
    return true;
  }
  bool operator()(std::vector<std::string>* field) const {
    *field = split_at_commas(words.back());
    return std::none_of(field->begin(), field->end(),
                        [](const auto& word) { return word.empty(); });
  }
  bool operator()(std::vector<fs::path>* field) const {
    field->assign(words.begin(), words.end());
    return std::none_of(words.begin(), words.end(), [](const auto& word) { return word.empty(); });
  }
  bool operator()(const Option::Choice& choice) const {
    const auto at = std::find(choice.names.begin(), choice.names.end(), words.back());
    if (at == choice.names.end()) return false;
    choice.set(static_cast<std::size_t>(at - choice.names.begin()));
    return true;
  }
};

std::string accepted_text(const Option& option) {
  static const std::vector<std::pair<std::string, std::string>> sentences = {
      {"INTEGER", "a whole number"},
      {"NUMBER", "a finite number"},
      {"INTEGER,...", "whole numbers separated by commas"},
      {"NUMBER,...", "finite numbers separated by commas"},
      {"TEXT,...", "words separated by commas"},
      {"PATH", "a path"},
      {"PATH...", "paths"}};
  const std::string type = option.type_text();
  for (const auto& [name, sentence] : sentences) {
    if (type != name) continue;
    const std::string range = option.range_text();
    if (range.empty()) return sentence;
    return sentence + (range[0] == 'a' ? " " : " in ") + range;
  }
  return "one of " + type;
}

}  // namespace

void Option::parse(const std::vector<std::string>& words) {
  if (is_flag()) {
    assert(words.empty() && "a flag has no value");
    *std::get<bool*>(field_) = !on_by_default_;
    return;
  }
  assert(!words.empty() && "an option has a value");
  if (!std::visit(FieldParser{words}, field_)) {
    throw UsageError(title(), "'" + words.back() + "' is not " + accepted_text(*this));
  }
  if (const auto rule = broken_rule()) throw UsageError(title(), *rule);
}

std::optional<std::string> Option::broken_rule() const {
  if (required_ && is_unset(field_)) return "is required";
  for (const double value : numbers_of(field_)) {
    const bool low = low_ && (low_open_ ? value <= *low_ : value < *low_);
    const bool high = high_ && value > *high_;
    if (!std::isfinite(value)) return "must be finite, but is " + number_text(value);
    if (!low && !high) continue;
    const std::string accepted = range_text();
    const std::string rule = accepted[0] == 'a' ? "must be " : "must be in ";
    return rule + accepted + ", but is " + number_text(value);
  }
  if (const auto* path = std::get_if<fs::path*>(&field_);
      path != nullptr && !ending_.empty() && !(*path)->empty() && (*path)->extension() != ending_) {
    return "must end in " + ending_ + ", but is " + (*path)->string();
  }
  if (const Choice* choice = std::get_if<Choice>(&field_);
      choice != nullptr && choice->get() >= choice->names.size()) {
    return "must be one of " + type_text();
  }
  if (const auto* text = std::get_if<std::string*>(&field_); text != nullptr && !words_.empty()) {
    if (std::find(words_.begin(), words_.end(), **text) == words_.end()) {
      return "must be one of " + type_text() + ", but is '" + **text + "'";
    }
  }
  return std::nullopt;
}

std::optional<std::string> first_broken_rule(const std::vector<Option>& options) {
  for (const Option& option : options) {
    if (const auto rule = option.broken_rule()) return option.title() + ": " + *rule;
  }
  return std::nullopt;
}

void check_options(const std::vector<Option>& options) {
  for (const Option& option : options) {
    if (const auto rule = option.broken_rule()) throw UsageError(option.title(), *rule);
  }
}

namespace {

/// Levenshtein 1966: fewest insertions, deletions and substitutions.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::vector<std::string> nearest_names(const std::string& word,
                                       const std::vector<std::string>& known) {
  std::vector<std::pair<std::size_t, std::string>> near;
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(word, name);
    const bool begins = word.size() >= 3 && name.starts_with(word);
    if (begins || distance <= std::max<std::size_t>(1, word.size() / 3)) {
      near.emplace_back(begins ? 0 : distance, name);
    }
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (std::size_t i = 0; i < near.size() && i < 3; ++i) names.push_back(near[i].second);
  return names;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const std::vector<std::string> near = nearest_names(word, known);
  return near.empty() ? std::string() : ", did you mean " + joined(near, " or ") + "?";
}

}  // namespace cornice
