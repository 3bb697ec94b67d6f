// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "core/base/error.h"
#include "tests/support/full_disk.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::read_text;
using test::TemporaryFolder;
using test::write_text;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class PlyReading : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& contents) const {
    write_text(folder_ / "a.ply", contents);
    return folder_ / "a.ply";
  }
  Mesh mesh(const std::string& contents) const { return read_ply_mesh(file(contents)); }
  std::string mesh_problem(const std::string& contents) const {
    try {
      mesh(contents);
    } catch (const InputError& error) {
      EXPECT_EQ(error.subject(), (folder_ / "a.ply").string());
      return error.problem();
    }
    return "accepted";
  }
  TemporaryFolder folder_;
};

template <class T>
std::string stored(T value, bool big_endian) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

const std::string kSquareHeader =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

TEST_F(PlyReading, TakesAsciiAndSplitsPolygonsIntoFans) {
  const Mesh m = mesh("ply\nformat ascii 1.0\ncomment made by hand\n" + kSquareHeader +
                      "0 0 0\n1 0 0\n1 1 0.5\n0 1e0 -0\n4 0 1 2 3\n");
  ASSERT_EQ(m.positions.size(), 4u);
  EXPECT_EQ(m.positions[2], (Vec3f{1.0f, 1.0f, 0.5f}));
  EXPECT_THAT(m.triangles, ElementsAre(std::array<std::uint32_t, 3>{0, 1, 2},
                                       std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_THAT(m.normals, IsEmpty());
}

TEST_F(PlyReading, TakesAsciiWithoutALastLineEndAndWithCarriageReturns) {
  std::string text =
      "ply\nformat ascii 1.0\n" + kSquareHeader + "0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1 2";
  EXPECT_EQ(mesh(text).triangles.size(), 1u);
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(mesh(windows).triangles.size(), 1u);
}

TEST_F(PlyReading, TakesBothByteOrders) {
  for (const bool big : {false, true}) {
    std::string text = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                       "_endian 1.0\n" + kSquareHeader;
    for (const float v : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 2.5f, 0.f, 1.f, 0.f}) {
      text += stored(v, big);
    }
    text += "\3" + stored(std::int32_t{2}, big) + stored(std::int32_t{1}, big) +
            stored(std::int32_t{3}, big);
    const Mesh m = mesh(text);
    EXPECT_EQ(m.positions[2], (Vec3f{1.0f, 1.0f, 2.5f})) << big;
    EXPECT_THAT(m.triangles, ElementsAre(std::array<std::uint32_t, 3>{2, 1, 3})) << big;
  }
}

TEST_F(PlyReading, TakesEveryNumericTypeUnderBothNames) {
  const std::string header =
      "ply\nformat binary_big_endian 1.0\nelement vertex 1\n"
      "property double x\nproperty float64 y\nproperty int32 z\n"
      "property char a\nproperty int8 b\nproperty uint8 c\nproperty short d\nproperty int16 e\n"
      "property ushort f\nproperty uint16 g\nproperty int h\nproperty uint i\nproperty uint32 j\n"
      "property float32 k\nproperty list uint16 double skipped\nproperty uchar l\nend_header\n";
  std::string body = stored(1.5, true) + stored(-2.25, true) + stored(std::int32_t{-7}, true);
  body += stored(std::int8_t{-1}, true) + stored(std::int8_t{-128}, true);
  body += stored(std::uint8_t{200}, true);
  body += stored(std::int16_t{-300}, true) + stored(std::int16_t{300}, true);
  body += stored(std::uint16_t{65535}, true) + stored(std::uint16_t{1}, true);
  body += stored(std::int32_t{-70000}, true) + stored(std::uint32_t{70000}, true);
  body += stored(std::uint32_t{3000000000u}, true) + stored(0.25f, true);
  body += stored(std::uint16_t{2}, true) + stored(1.0, true) + stored(2.0, true);
  body += stored(std::uint8_t{9}, true);
  const Mesh m = mesh(header + body);
  EXPECT_EQ(m.positions[0], (Vec3f{1.5f, -2.25f, -7.0f}));
  std::vector<float> values;
  for (const auto& property : m.float_properties) values.push_back(property.values.at(0));
  EXPECT_THAT(values, ElementsAre(-1.f, -128.f, -300.f, 300.f, 65535.f, 1.f, -70000.f, 70000.f,
                                  3e9f, 0.25f));
  ASSERT_EQ(m.byte_properties.size(), 2u);
  EXPECT_EQ(m.byte_properties[0].values[0], 200);
  EXPECT_EQ(m.byte_properties[1].name, "l");
  EXPECT_EQ(m.byte_properties[1].values[0], 9);
}

TEST_F(PlyReading, PassesOverForeignElementsAndPropertiesAroundTheFaces) {
  const Mesh m = mesh(
      "ply\nformat ascii 1.0\nelement camera 1\nproperty float f\nproperty list uchar int ids\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty uchar colour\nproperty list int uint vertex_index\n"
      "property list uchar float uv\nelement edge 1\nproperty int v\nend_header\n"
      "35.5 2 7 8\n0 0 0\n1 0 0\n0 1 0\n255 3 0 1 2 2 0.5 0.5\n1\n");
  EXPECT_THAT(m.triangles, ElementsAre(std::array<std::uint32_t, 3>{0, 1, 2}));
}

TEST_F(PlyReading, KeepsLargeDoublePositionsToTheMillimetreByMovingTheOrigin) {
  const Mesh m = mesh(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
      "property double z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n"
      "2600000.123 1200000.456 1500.789\n2600001.001 1200002.002 1400.003\n");
  EXPECT_EQ(m.origin, (Vec3d{2600000.0, 1200000.0, 1400.0}));
  const Vec3d p = m.origin + m.positions[0].cast<double>();
  EXPECT_NEAR(p.x, 2600000.123, 1e-4);
  EXPECT_NEAR(p.y, 1200000.456, 1e-4);
  EXPECT_NEAR(p.z, 1500.789, 1e-4);
}

TEST_F(PlyReading, ReadsOriginAndCrsFromComments) {
  const PlyInfo info =
      read_ply_info(file("ply\nformat ascii 1.0\ncomment cornice origin 2600000 1200000.5 -3\n"
                         "comment cornice crs EPSG:2056+5728\nobj_info by hand\nelement vertex 0\n"
                         "property list uchar int odd\nend_header\n"));
  EXPECT_EQ(info.origin, (Vec3d{2600000.0, 1200000.5, -3.0}));
  EXPECT_EQ(info.crs_text, "EPSG:2056+5728");
  EXPECT_EQ(info.format, "ascii");
  EXPECT_EQ(info.comments.size(), 3u);
  ASSERT_EQ(info.elements.size(), 1u);
  EXPECT_EQ(info.elements[0].properties[0].second, "list uchar int");
}

TEST_F(PlyReading, TellsHowManyOfAnElementTheHeaderPromises) {
  const PlyInfo info =
      read_ply_info(file("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                         "element face 0\nproperty list uchar int vertex_indices\nend_header\n"
                         "1\n2\n"));
  EXPECT_EQ(info.count("vertex"), 2u);
  EXPECT_EQ(info.count("face"), 0u);
  EXPECT_EQ(info.count("edge"), 0u);
}

TEST_F(PlyReading, TakesForeignPointsWithNormalsOfEitherName) {
  const OrientedPoints points = read_ply_points(
      file("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
           "property float z\nproperty float normal_x\nproperty float normal_y\n"
           "property float normal_z\nend_header\n1 2 3 0 0 1\n"));
  EXPECT_THAT(points.normals, ElementsAre(Vec3f{0.0f, 0.0f, 1.0f}));
  EXPECT_THAT(points.quality, IsEmpty());
}

TEST_F(PlyReading, RefusesPointsWithoutNormals) {
  EXPECT_THROW(read_ply_points(file("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                    "property float y\nproperty float z\nend_header\n1 2 3\n")),
               InputError);
}

TEST_F(PlyReading, RefusesWhatIsNoPlyInOneClearLine) {
  EXPECT_THROW(read_ply_mesh(folder_ / "absent.ply"), InputError);
  EXPECT_THROW(read_ply_mesh(folder_.path()), InputError);
  EXPECT_THAT(mesh_problem(""), HasSubstr("is empty"));
  EXPECT_THAT(mesh_problem("LASF"), HasSubstr("is no PLY"));
  EXPECT_THAT(mesh_problem("plywood\n"), HasSubstr("is no PLY"));
  EXPECT_THAT(mesh_problem("ply"), HasSubstr("ends within the header"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\nelement vertex 3\n"),
              HasSubstr("ends within the header (header line 4)"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 2.0\nend_header\n"), HasSubstr("is not 1.0"));
  EXPECT_THAT(mesh_problem("ply\nformat utf8 1.0\nend_header\n"), HasSubstr("unknown format"));
  EXPECT_THAT(mesh_problem("ply\nend_header\n"), HasSubstr("no format line"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\nelement vertex -1\nend_header\n"),
              HasSubstr("'-1' is no count"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\nelement vertex 1e3\nend_header\n"),
              HasSubstr("no count"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n"),
              HasSubstr("unknown type 'half' (header line 4)"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\nproperty float x\nend_header\n"),
              HasSubstr("before any element"));
  EXPECT_THAT(
      mesh_problem("ply\nformat ascii 1.0\nelement f 1\nproperty list float int v\nend_header\n"),
      HasSubstr("must be an integer"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\ncomment cornice origin 1 2\nend_header\n"),
              HasSubstr("is not 'cornice origin E N H'"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\ncomment cornice origin 1 2 nan\nend_header\n"),
              HasSubstr("is not 'cornice origin E N H'"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\nend_header\n"), HasSubstr("has no vertices"));
  EXPECT_THAT(mesh_problem("ply\n" + std::string(2 << 20, '\n')), HasSubstr("does not end"));
}

TEST_F(PlyReading, RefusesCountsThatTheFileCannotHold) {
  const std::string start = "ply\nformat binary_little_endian 1.0\nelement vertex ";
  const std::string rest = "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const char* count : {"4000000000", "18446744073709551615", "1537228672809129302", "2"}) {
    EXPECT_THAT(mesh_problem(start + count + rest + std::string(12, '\0')),
                HasSubstr("is truncated"))
        << count;
  }
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n1"),
              HasSubstr("has no properties"));
}

TEST_F(PlyReading, RefusesAListThatGoesBeyondTheFile) {
  const std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n" +
      std::string(12, '\0');
  EXPECT_THAT(mesh_problem(text + "\xff\xff\xff\xff"), HasSubstr("beyond the file's end (face 0)"));
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\n" + kSquareHeader +
                           "0 0 0\n1 0 0\n1 1 0\n0 1 0\n-4 0 1 2 3\n"),
              HasSubstr("not of its type uchar (face 0)"));
}

TEST_F(PlyReading, SaysWhereAFileIsTruncated) {
  Mesh m;
  m.positions.assign(5000, Vec3f{1.0f, 2.0f, 3.0f});
  m.triangles.assign(100, {0, 1, 2});
  write_ply(folder_ / "whole.ply", m);
  const std::string whole = read_text(folder_ / "whole.ply");
  EXPECT_EQ(mesh_problem(whole), "accepted");
  for (const std::size_t cut : {1, 7, 13, 1300}) {
    EXPECT_THAT(mesh_problem(whole.substr(0, whole.size() - cut)), HasSubstr("is truncated"))
        << cut;
  }
  const std::string ascii = "ply\nformat ascii 1.0\n" + kSquareHeader + "0 0 0\n1 0 0\n1 1 ";
  EXPECT_THAT(mesh_problem(ascii + std::string(40, ' ')),
              HasSubstr("is truncated: the file ends (vertex 2)"));
}

TEST_F(PlyReading, RefusesIndicesThatAreNotThere) {
  const std::string start =
      "ply\nformat ascii 1.0\n" + kSquareHeader + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  EXPECT_THAT(mesh_problem(start + "3 0 1 4\n"), HasSubstr("not there; there are 4 (face 0)"));
  EXPECT_THAT(mesh_problem(start + "3 0 1 -1\n"), HasSubstr("not there"));
  EXPECT_THAT(mesh_problem(start + "2 0 1\n"), HasSubstr("a face has 2 corners"));
  std::string binary =
      "ply\nformat binary_little_endian 1.0\n" + kSquareHeader + std::string(48, '\0');
  EXPECT_THAT(mesh_problem(binary + "\3" + stored(std::int32_t{0}, false) +
                           stored(std::int32_t{1}, false) + stored(std::int32_t{-1}, false)),
              HasSubstr("not there"));
}

TEST_F(PlyReading, RefusesPositionsAndNormalsThatAreNotFinite) {
  const std::string start = "ply\nformat ascii 1.0\n" + kSquareHeader;
  EXPECT_EQ(mesh_problem(start + "0 0 0\n1 nan 0\n1 1 0\n0 1 0\n3 0 1 2\n"),
            "vertex 1 has a position that is not finite");
  EXPECT_EQ(mesh_problem(start + "0 0 0\n1 0 0\n1 1 0\n0 inf 0\n3 0 1 2\n"),
            "vertex 3 has a position that is not finite");
  EXPECT_THAT(mesh_problem(start + "0 0 0\n1 x 0\n1 1 0\n0 1 0\n3 0 1 2\n"),
              HasSubstr("is not a number (vertex 1)"));
}

TEST_F(PlyReading, RefusesTriangleStripsInsteadOfGivingNoTriangles) {
  EXPECT_THAT(mesh_problem("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                           "property float y\nproperty float z\nelement tristrips 1\n"
                           "property list int int vertex_indices\nend_header\n0 0 0\n1 0\n"),
              HasSubstr("triangle strips"));
}

TEST(PlyWriting, RefusesWhatIsNotFiniteAndLeavesNoFile) {
  const TemporaryFolder folder;
  OrientedPoints points;
  points.positions = {{0.0f, 0.0f, 0.0f}, {1.0f, std::numeric_limits<float>::quiet_NaN(), 0.0f}};
  points.normals = {{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 1.0f}};
  EXPECT_THROW(write_ply(folder / "a.ply", points), RunError);
  points.positions[1].y = 0.0f;
  points.normals[0].z = std::numeric_limits<float>::infinity();
  EXPECT_THROW(write_ply(folder / "a.ply", points), RunError);
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(PlyWriting, RefusesArraysThatDoNotFitTogether) {
  const TemporaryFolder folder;
  Mesh m;
  m.positions.resize(3);
  m.triangles = {{0, 1, 3}};
  EXPECT_THROW(write_ply(folder / "a.ply", m), std::invalid_argument);
  m.triangles = {{0, 1, 2}};
  m.float_properties = {{"support", {1.0f}}};
  EXPECT_THROW(write_ply(folder / "a.ply", m), std::invalid_argument);
  m.float_properties = {{"two words", {1.0f, 2.0f, 3.0f}}};
  EXPECT_THROW(write_ply(folder / "a.ply", m), std::invalid_argument);
  m.float_properties = {{"x", {1.0f, 2.0f, 3.0f}}};
  EXPECT_THROW(write_ply(folder / "a.ply", m), std::invalid_argument);
  OrientedPoints points;
  points.positions.resize(3);
  EXPECT_THROW(write_ply(folder / "a.ply", points), std::invalid_argument);
  EXPECT_THAT(folder.entries(), IsEmpty());
}

TEST(PlyWriting, TellsOfAFullDiskAndLeavesNothing) {
  const TemporaryFolder folder;
  Mesh m;
  m.positions.resize(50000);
  const auto outcome = test::on_full_disk(folder.path(), [&] { write_ply(folder / "a.ply", m); });
  if (!outcome) GTEST_SKIP() << "this machine does not let a test mount a small disk";
  EXPECT_EQ(*outcome, (folder / "a.ply").string() +
                          ": cannot be written: the disk is full; free some space or write "
                          "elsewhere, then run again");
}

TEST(PlyWriting, HasTheHeaderThatTheFormatPageShows) {
  const TemporaryFolder folder;
  OrientedPoints points;
  points.origin = {2600000.0, 1200000.25, 0.1};
  points.crs_text = "PROJCS[\"LV95\",\n AXIS]";
  points.positions = {{1.0f, 2.0f, 3.0f}};
  points.normals = {{0.0f, 0.0f, 1.0f}};
  points.quality = {0.5f};
  points.float_properties = {{"intensity", {7.0f}}};
  points.byte_properties = {{"class", {2}}};
  points.line_id = {3};
  write_ply(folder / "a.ply", points);
  const std::string text = read_text(folder / "a.ply");
  const std::string header = text.substr(0, text.find("end_header\n"));
  EXPECT_EQ(header,
            "ply\nformat binary_little_endian 1.0\ncomment cornice origin 2600000 1200000.25 0.1\n"
            "comment cornice crs PROJCS[\"LV95\",  AXIS]\nelement vertex 1\n"
            "property float x\nproperty float y\nproperty float z\n"
            "property float nx\nproperty float ny\nproperty float nz\n"
            "property float quality\nproperty float intensity\nproperty uchar class\n"
            "property ushort line_id\n");
  EXPECT_EQ(text.size(), header.size() + 11 + 24 + 8 + 1 + 2);
}

}  // namespace
}  // namespace cornice
