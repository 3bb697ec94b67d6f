// SPDX-License-Identifier: GPL-3.0-or-later
// The front executable: finds cornice-NAME beside itself or on PATH and becomes it.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/cli/log.h"
#include "core/cli/options.h"
#include "core/cli/version.h"

namespace {

namespace fs = std::filesystem;

struct StageLine {
  const char* name;
  const char* line;
};

// In the order in which data passes through them.
constexpr std::array<StageLine, 14> kStages{{
    {"run", "takes a survey through every stage, by a configuration"},
    {"simulate", "flies a scanner over an analytic scene: LAZ tiles and their truth"},
    {"info", "says what is in a LAS, LAZ, COPC, PLY or GeoTIFF file"},
    {"index", "lays out the tiles of a survey from their headers"},
    {"flightlines", "splits tiles into flight lines and finds the sensor's path"},
    {"normals", "estimates normals that point out of the ground"},
    {"poisson", "reconstructs the surface of a tile, to meet its neighbours'"},
    {"trim", "takes surface without measurements off a mesh"},
    {"remesh", "makes few, well-shaped triangles that stay close to a mesh"},
    {"stitch", "makes the mesh tiles of a survey share their border vertices"},
    {"dem", "makes meshes of DEM tiles, or a raster of meshes"},
    {"hlod", "builds hierarchies of levels of detail, and says what is in them"},
    {"compare", "measures how two surfaces of one place differ"},
    {"viewer", "shows hierarchies in a window, or draws pictures of them"},
}};

bool is_stage(const std::string& name) {
  return std::any_of(kStages.begin(), kStages.end(),
                     [&](const StageLine& stage) { return name == stage.name; });
}

std::string help_text() {
  std::string text =
      "Airborne LiDAR to one seamless mesh of the ground, overhangs included.\n\n"
      "Usage: cornice STAGE [arguments]     the same as cornice-STAGE [arguments]\n"
      "       cornice STAGE --help\n\nStages\n";
  for (const StageLine& stage : kStages) {
    std::string left = std::string("  ") + stage.name;
    left.resize(16, ' ');
    text += left + stage.line + "\n";
  }
  return text + "\nExamples\n  cornice info tile.laz\n  cornice normals tile.laz -o points.ply\n";
}

/// Path of the executable, or empty: beside this one first, so that a build tree runs its own.
fs::path find_executable(const std::string& name) {
  std::error_code error;
  std::vector<fs::path> folders{fs::read_symlink("/proc/self/exe", error).parent_path()};
  const char* path = std::getenv("PATH");
  const std::string list = path == nullptr ? "" : path;
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find(':', begin), list.size());
    if (end > begin) folders.emplace_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  for (const fs::path& folder : folders) {
    const fs::path candidate = folder / name;
    if (fs::is_regular_file(candidate, error) && access(candidate.c_str(), X_OK) == 0) {
      return candidate;
    }
  }
  return {};
}

/// Becomes the stage; returns only with an error.
int become(const std::string& stage, std::vector<std::string> arguments) {
  const std::string tool = "cornice-" + stage;
  const bool is_plain = stage.find('/') == std::string::npos;
  const fs::path executable = is_plain ? find_executable(tool) : fs::path();
  if (executable.empty() && is_stage(stage)) {
    cornice::log_error(tool + ": is neither beside cornice nor on PATH; install it");
    return static_cast<int>(cornice::ExitCode::kFailed);
  }
  if (executable.empty()) {
    std::vector<std::string> known;
    for (const StageLine& line : kStages) known.emplace_back(line.name);
    cornice::log_error(stage + ": unknown stage" + cornice::did_you_mean(stage, known) +
                       " (see cornice --help)");
    return static_cast<int>(cornice::ExitCode::kUsage);
  }
  arguments.insert(arguments.begin(), tool);
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  execv(executable.c_str(), words.data());
  cornice::log_error(executable.string() + ": " + std::generic_category().message(errno));
  return static_cast<int>(cornice::ExitCode::kFailed);
}

}  // namespace

int main(int argc, char** argv) {
  cornice::set_up_log("cornice", "info");
  std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
  if (arguments.empty()) {
    cornice::log_error("which stage? (see cornice --help)");
    return static_cast<int>(cornice::ExitCode::kUsage);
  }
  std::string first = arguments.front();
  arguments.erase(arguments.begin());
  if (first == "--version" || first == "-v") {
    std::puts(("cornice " + cornice::version_text()).c_str());
    return 0;
  }
  const bool wants_help = first == "--help" || first == "-h" || first == "help";
  if (wants_help && arguments.empty()) {
    std::fputs(help_text().c_str(), stdout);
    return 0;
  }
  if (wants_help) {
    first = arguments.front();
    arguments = {"--help"};
  }
  if (first.starts_with("-")) {
    cornice::log_error(first +
                       ": unknown option; the stage's name comes first (see cornice --help)");
    return static_cast<int>(cornice::ExitCode::kUsage);
  }
  return become(first, std::move(arguments));
}
