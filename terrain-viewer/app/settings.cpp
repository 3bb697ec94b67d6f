// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"

namespace cornice::viewer {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int kLeastWindow = 160, kMostWindow = 16384;

fs::path absolute_of(const fs::path& file) {
  std::error_code error;
  const fs::path whole = fs::absolute(file, error).lexically_normal();
  return error ? file : whole;
}

/// Nothing for what is no bookmark.
std::optional<Settings::Marked> marked_from(const json& entry) {
  const auto text = [&](const char* key) { return entry.value(key, std::string()); };
  const auto number = [&](const char* key) { return entry.at(key).get<double>(); };
  try {
    Settings::Marked m{text("file"), {text("name"), {}}};
    Camera& camera = m.bookmark.camera;
    const auto eye = entry.at("eye").get<std::array<double, 3>>();
    camera.eye = {eye[0], eye[1], eye[2]};
    camera.heading_deg = number("heading_deg");
    camera.pitch_deg = number("pitch_deg");
    camera.field_of_view_deg = number("field_of_view_deg");
    const bool is_sane = std::abs(camera.pitch_deg) <= 90.0 && camera.field_of_view_deg >= 1.0 &&
                         camera.field_of_view_deg <= 120.0;
    if (!m.file.empty() && is_sane) return m;
  } catch (const json::exception&) {
    // It is none, then.
  }
  return std::nullopt;
}

ordered_json json_of(const Settings::Marked& m) {
  const Camera& camera = m.bookmark.camera;
  return {{"file", m.file.string()},
          {"name", m.bookmark.name},
          {"eye", {camera.eye.x, camera.eye.y, camera.eye.z}},
          {"heading_deg", camera.heading_deg},
          {"pitch_deg", camera.pitch_deg},
          {"field_of_view_deg", camera.field_of_view_deg}};
}

/// A value is taken where it is there and makes sense.
class Reader {
 public:
  explicit Reader(const json& document) : document_(document) {}

  void number(const char* key, double low, double high, double& to) {
    const auto found = document_.find(key);
    if (found == document_.end()) return;
    if (found->is_number() && found->get<double>() >= low && found->get<double>() <= high)
      to = found->get<double>();
    else
      refuse(key);
  }
  void pixels(const char* key, int& to) {
    double value = to;
    number(key, kLeastWindow, kMostWindow, value);
    to = static_cast<int>(value);
  }
  void flag(const char* key, bool& to) {
    const auto found = document_.find(key);
    if (found == document_.end()) return;
    if (found->is_boolean())
      to = found->get<bool>();
    else
      refuse(key);
  }
  void shading(const char* key, Shading& to) {
    const auto found = document_.find(key);
    if (found == document_.end()) return;
    const auto named = found->is_string() ? shading_named(found->get<std::string>()) : std::nullopt;
    if (named)
      to = *named;
    else
      refuse(key);
  }
  void paths(const char* key, std::vector<fs::path>& to) {
    const auto found = document_.find(key);
    if (found == document_.end()) return;
    if (!found->is_array()) return refuse(key);
    for (const json& entry : *found) {
      if (!entry.is_string()) return refuse(key);
      if (to.size() < Settings::kMostRecent) to.emplace_back(entry.get<std::string>());
    }
  }
  void bookmarks(const char* key, std::vector<Settings::Marked>& to) {
    const auto found = document_.find(key);
    if (found == document_.end()) return;
    if (!found->is_array()) return refuse(key);
    for (const json& entry : *found) {
      auto m = marked_from(entry);
      if (!m) return refuse(key);
      if (to.size() < Settings::kMostMarked) to.push_back(std::move(*m));
    }
  }
  const std::string& refused() const { return refused_; }

 private:
  void refuse(const char* key) {
    refused_ += (refused_.empty() ? "\"" : ", \"") + std::string(key) + "\"";
  }
  const json& document_;
  std::string refused_;
};

}  // namespace

void Settings::opened(const fs::path& file) {
  fs::path whole = absolute_of(file);
  std::erase(recent, whole);
  recent.insert(recent.begin(), std::move(whole));
  if (recent.size() > kMostRecent) recent.resize(kMostRecent);
}

std::vector<Bookmark> Settings::bookmarks_of(const fs::path& file) const {
  std::vector<Bookmark> bookmarks;
  for (const Marked& m : marked)
    if (m.file == absolute_of(file)) bookmarks.push_back(m.bookmark);
  return bookmarks;
}

void Settings::set_bookmarks(const fs::path& file, const std::vector<Bookmark>& bookmarks) {
  const fs::path whole = absolute_of(file);
  std::erase_if(marked, [&](const Marked& m) { return m.file == whole; });
  for (const Bookmark& bookmark : bookmarks) marked.push_back({whole, bookmark});
  if (marked.size() > kMostMarked)
    marked.erase(marked.begin(), marked.end() - static_cast<std::ptrdiff_t>(kMostMarked));
}

fs::path settings_path() {
  // The specification of base directories says that relative paths are to be ignored.
  const auto folder = [](const char* variable) {
    const char* text = std::getenv(variable);
    const fs::path path = text != nullptr ? text : "";
    return path.is_absolute() ? path : fs::path();
  };
  if (const fs::path config = folder("XDG_CONFIG_HOME"); !config.empty())
    return config / "cornice" / "viewer.json";
  if (const fs::path home = folder("HOME"); !home.empty())
    return home / ".config" / "cornice" / "viewer.json";
  return {};
}

SettingsRead read_settings(const fs::path& path) {
  SettingsRead read;
  std::error_code error;
  if (path.empty() || !fs::exists(path, error)) return read;
  json document;
  if (fs::is_regular_file(path, error)) {
    std::ifstream in(path);
    document = json::parse(in, nullptr, false);
  }
  if (!document.is_object()) {
    read.problem = path.string() + ": is no settings file; it is ignored and written anew";
    return read;
  }
  Settings& s = read.settings;
  Reader reader(document);
  reader.pixels("window_width", s.window.width);
  reader.pixels("window_height", s.window.height);
  reader.shading("shading", s.shading);
  reader.number("contours_m", 0.0, 1000.0, s.contour_interval_m);
  reader.number("error_pixels", 0.1, 100.0, s.error_pixels);
  reader.number("frame_ms", 0.0, 1000.0, s.frame_ms);
  reader.flag("edges", s.has_edges);
  reader.flag("shows_layers", s.shows_layers);
  reader.flag("shows_frames", s.shows_frames);
  reader.paths("recent", s.recent);
  reader.bookmarks("bookmarks", s.marked);
  if (!reader.refused().empty())
    read.problem = path.string() + ": " + reader.refused() + " make no sense and are ignored";
  return read;
}

void write_settings(const fs::path& path, const Settings& settings) {
  const ordered_json document{
      {"window_width", settings.window.width},
      {"window_height", settings.window.height},
      {"shading", kShadingNames[static_cast<std::size_t>(settings.shading)]},
      {"contours_m", settings.contour_interval_m},
      {"error_pixels", settings.error_pixels},
      {"frame_ms", settings.frame_ms},
      {"edges", settings.has_edges},
      {"shows_layers", settings.shows_layers},
      {"shows_frames", settings.shows_frames}};
  ordered_json whole = document;
  whole["recent"] = ordered_json::array();
  for (const fs::path& file : settings.recent) whole["recent"].push_back(file.string());
  whole["bookmarks"] = ordered_json::array();
  for (const Settings::Marked& m : settings.marked) whole["bookmarks"].push_back(json_of(m));
  // A path may hold bytes that are no UTF-8; those are replaced, and the file is not found again.
  write_file_atomically(path, whole.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
}

void apply(const Settings& settings, Options& options) {
  options.size =
      std::to_string(settings.window.width) + "x" + std::to_string(settings.window.height);
  options.shading = settings.shading;
  options.contour_interval_m = settings.contour_interval_m;
  options.error_pixels = settings.error_pixels;
  options.frame_ms = settings.frame_ms;
  options.has_edges = settings.has_edges;
}

}  // namespace cornice::viewer
