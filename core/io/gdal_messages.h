// SPDX-License-Identifier: GPL-3.0-or-later
// What GDAL says when it fails. For .cpp files that use GDAL.
#pragma once

#include <cpl_error.h>

#include <string>

namespace cornice {

/// Keeps GDAL's messages off stderr on this thread and remembers the last error.
class GdalMessages {
 public:
  GdalMessages() {
    CPLErrorReset();
    CPLPushErrorHandlerEx(&GdalMessages::take, this);
  }
  ~GdalMessages() { CPLPopErrorHandler(); }
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;

  /// ": what GDAL says", or empty.
  std::string tail() const { return text_.empty() ? text_ : ": " + text_; }

 private:
  static void CPL_STDCALL take(CPLErr level, CPLErrorNum, const char* message) {
    auto* self = static_cast<GdalMessages*>(CPLGetErrorHandlerUserData());
    if (level >= CE_Failure) self->text_ = message;
  }
  std::string text_;
};

}  // namespace cornice
