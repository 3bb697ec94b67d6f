// SPDX-License-Identifier: GPL-3.0-or-later
// GDAL's C handles as values that end by themselves. For .cpp files that use GDAL.
#pragma once

#include <cpl_error.h>
#include <gdal.h>

#include <memory>

namespace cornice {

/// Keeps GDAL's messages off stderr on this thread; a failure is told by the return value.
class QuietGdal {
 public:
  QuietGdal() { CPLPushErrorHandler(CPLQuietErrorHandler); }
  ~QuietGdal() { CPLPopErrorHandler(); }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
};

struct DatasetCloser {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
using DatasetPtr = std::unique_ptr<void, DatasetCloser>;

}  // namespace cornice
