// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/picture.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace cornice::test {

Picture read_png(const std::filesystem::path& path) {
  const auto input = OIIO::ImageInput::open(path.string());
  if (!input) throw std::runtime_error(path.string() + ": " + OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  const auto pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  std::vector<std::uint8_t> bytes(pixels * channels);
  if (channels < 3 ||
      !input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, bytes.data()))
    throw std::runtime_error(path.string() + ": is no picture of three channels");
  Picture picture;
  picture.width = spec.width;
  picture.height = spec.height;
  for (std::size_t i = 0; i < pixels; ++i)
    picture.pixels.push_back(
        {bytes[i * channels], bytes[i * channels + 1], bytes[i * channels + 2]});
  return picture;
}

std::size_t count_of(const Picture& picture, std::array<std::uint8_t, 3> colour) {
  return static_cast<std::size_t>(std::count(picture.pixels.begin(), picture.pixels.end(), colour));
}

PictureDifference compare_pictures(const Picture& a, const Picture& b) {
  if (a.width != b.width || a.height != b.height) throw std::runtime_error("sizes differ");
  PictureDifference difference;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    int largest = 0;
    for (std::size_t c = 0; c < 3; ++c)
      largest = std::max(largest, std::abs(int{a.pixels[i][c]} - int{b.pixels[i][c]}));
    ++difference.counts[static_cast<std::size_t>(largest)];
    sum += largest;
  }
  difference.mean = sum / static_cast<double>(a.pixels.size());
  return difference;
}

double PictureDifference::share_within(int limit) const {
  std::size_t within = 0, all = 0;
  for (int i = 0; i < 256; ++i) {
    all += counts[static_cast<std::size_t>(i)];
    if (i <= limit) within += counts[static_cast<std::size_t>(i)];
  }
  return static_cast<double>(within) / static_cast<double>(all);
}

}  // namespace cornice::test
