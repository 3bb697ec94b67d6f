// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/dropped_files.h"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <system_error>

#include "core/base/error.h"

namespace cornice::viewer {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHierarchy = ".hlod";

bool is_raster_name(const fs::path& file) {
  constexpr std::array kEndings{".tif", ".tiff", ".vrt", ".jp2", ".asc"};
  return std::find(kEndings.begin(), kEndings.end(), file.extension()) != kEndings.end();
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> hierarchies, rasters;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->path().extension() == kHierarchy) hierarchies.push_back(at->path());
    if (is_raster_name(at->path())) rasters.push_back(at->path());
  }
  std::vector<fs::path>& found = hierarchies.empty() ? rasters : hierarchies;
  std::sort(found.begin(), found.end());
  return found;
}

bool holds(const std::vector<fs::path>& files, const fs::path& file) {
  return std::any_of(files.begin(), files.end(), [&](const fs::path& other) {
    std::error_code error;
    return fs::equivalent(other, file, error) && !error;
  });
}

/// Several names in a line of readable length.
std::string listed(const std::vector<fs::path>& files) {
  constexpr std::size_t kMost = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(kMost, files.size()); ++i)
    names += (i > 0 ? ", " : "") + files[i].filename().string();
  if (files.size() > kMost) names += " and " + std::to_string(files.size() - kMost) + " more";
  return names;
}

/// Opens files one after the other and remembers what came of it.
class Opening {
 public:
  Opening(Session& session, const std::vector<fs::path>& layers)
      : session_(session), layers_(layers) {}

  void add(const fs::path& path) {
    std::error_code error;
    if (fs::is_directory(path, error))
      return refuse(path.string() + ": is a folder without hierarchies (.hlod) and rasters");
    if (!fs::exists(path, error)) return refuse(path.string() + ": is not there");
    if (path.extension() == kHierarchy) return add_layer(path);
    const auto kind = raster_kind(path);
    if (!kind)
      return refuse(
          path.string() +
          ": is neither a hierarchy of cornice-hlod (.hlod) nor a raster that GDAL reads");
    (*kind == RasterKind::kPhoto ? photos_ : values_).push_back(path);
  }
  Opened finish() {
    drape(values_, RasterKind::kValues);
    drape(photos_, RasterKind::kPhoto);
    Opened opened{std::move(hierarchies_), {}};
    if (!done_.empty()) opened.message = "opened " + listed(done_);
    if (problems_.empty()) return opened;
    opened.message += (done_.empty() ? "" : "; not opened: ") + problems_.front();
    if (problems_.size() > 1)
      opened.message += " (and " + std::to_string(problems_.size() - 1) + " more not opened)";
    return opened;
  }

 private:
  void refuse(std::string problem) { problems_.push_back(std::move(problem)); }
  void attempt(const std::function<void()>& open, const std::vector<fs::path>& files) {
    try {
      open();
      done_.insert(done_.end(), files.begin(), files.end());
    } catch (const Error& error) {
      refuse(error.what());
    } catch (const std::bad_alloc&) {
      refuse(files.front().string() + ": needs more memory than there is");
    }
  }
  void add_layer(const fs::path& path) {
    if (holds(layers_, path) || holds(hierarchies_, path))
      return refuse(path.string() + ": is a layer already");
    attempt(
        [&] {
          session_.add_layer(path);
          hierarchies_.push_back(path);
        },
        {path});
  }
  void drape(const std::vector<fs::path>& files, RasterKind kind) {
    if (!files.empty()) attempt([&] { session_.add_drape(files, kind); }, files);
  }

  Session& session_;
  const std::vector<fs::path>& layers_;
  std::vector<fs::path> photos_, values_, hierarchies_, done_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<fs::path> without_folders(const std::vector<fs::path>& paths) {
  std::vector<fs::path> files;
  for (const fs::path& path : paths) {
    std::error_code error;
    const auto inside = fs::is_directory(path, error) ? files_in(path) : std::vector<fs::path>{};
    if (inside.empty())
      files.push_back(path);
    else
      files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

Opened open_files(Session& session, const std::vector<fs::path>& layers,
                  const std::vector<fs::path>& paths) {
  Opening opening(session, layers);
  for (const fs::path& path : without_folders(paths)) opening.add(path);
  return opening.finish();
}

}  // namespace cornice::viewer
