// SPDX-License-Identifier: GPL-3.0-or-later
// Every kind of bad point file ends in one line that names the file, what is wrong where, and what
// to do, or gives what can be read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "core/base/error.h"
#include "core/base/memory.h"
#include "core/io/las_header.h"
#include "core/io/laz_chunk_table.h"
#include "core/io/little_endian.h"
#include "tests/property/las_writer/clouds.h"
#include "tests/support/small_files.h"
#include "tests/support/temporary_folder.h"

namespace cornice::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr std::size_t kPoints = 1000;

LasWriteOptions las12() {
  LasWriteOptions options;
  options.version_minor = 2;
  options.point_format = 1;
  options.compress = false;
  return options;
}
LasWriteOptions las14() {
  LasWriteOptions options;
  options.compress = false;
  return options;
}
LasWriteOptions laz(int format) {
  LasWriteOptions options;
  options.point_format = format;
  options.version_minor = format < 6 ? 2 : 4;
  options.chunk_points = 100;
  return options;
}
LasWriteOptions with_vlr(LasWriteOptions options, LasVlr vlr) {
  options.vlrs.push_back(std::move(vlr));
  return options;
}
Bytes text(const std::string& words) { return {words.begin(), words.end()}; }

std::size_t points_at(const Bytes& file) { return load_le<std::uint32_t>(file, at::kPointOffset); }

/// Byte of the LASzip record's data at which `offset` lies.
std::size_t laszip_record(const Bytes& file, std::size_t offset) {
  const std::string mark = "laszip encoded";
  const auto found = std::search(file.begin(), file.end(), mark.begin(), mark.end());
  return static_cast<std::size_t>(found - file.begin()) + 52 + offset;
}

struct BadFile {
  const char* name;
  std::function<Bytes()> bytes;
  std::vector<std::string> words;  ///< that the error must have
};

std::string read_error(const std::filesystem::path& path) {
  try {
    const LasInfo info = read_las_info(path);
    read_las(info, {.attributes = Attribute::kAll});
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), ExitCode::kBadInput);
    EXPECT_EQ(error.subject(), path.string());
    return error.what();
  }
  return "no error";
}

void expect_clear_line(const std::string& error, const std::filesystem::path& path,
                       const std::vector<std::string>& words) {
  EXPECT_THAT(error, StartsWith(path.string() + ": "));
  EXPECT_THAT(error, Not(HasSubstr("\n")));
  EXPECT_THAT(error, HasSubstr("; ")) << "no remedy";
  for (const std::string& word : words) EXPECT_THAT(error, HasSubstr(word));
}

std::vector<BadFile> bad_headers() {
  return {
      {"empty", [] { return Bytes{}; }, {"is empty", "0 bytes"}},
      {"git_lfs_pointer",
       [] { return text("version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 9\n"); },
       {"git-lfs pointer", "git lfs pull"}},
      {"text", [] { return text("x,y,z\n1,2,3\n"); }, {"'LASF'"}},
      {"four_bytes", [] { return text("LASF"); }, {"inside the header", "4 bytes"}},
      {"cut_in_header",
       [] { return cut(point_file(las12(), kPoints), 100); },
       {"inside the header", "100 of 227"}},
      {"cut_in_header_of_1_4",
       [] { return cut(point_file(las14(), kPoints), 300); },
       {"inside the header", "300 of 375"}},
      {"header_only",
       [] { return cut(point_file(las12(), kPoints), 227); },
       {"points", "byte 227"}},
      {"version_2",
       [] { return patched<std::uint8_t>(point_file(las12(), 3), at::kMajor, 2); },
       {"version 2.2", "1.0 to 1.4"}},
      {"version_1_5",
       [] { return patched<std::uint8_t>(point_file(las12(), 3), at::kMinor, 5); },
       {"version 1.5"}},
      {"header_size_0",
       [] { return patched<std::uint16_t>(point_file(las14(), 3), at::kHeaderBytes, 0); },
       {"byte 94", "375"}},
      {"points_in_header",
       [] { return patched<std::uint32_t>(point_file(las12(), 3), at::kPointOffset, 100); },
       {"byte 96", "inside its header"}},
      {"points_behind_end",
       [] { return patched<std::uint32_t>(point_file(las12(), 3), at::kPointOffset, 99999); },
       {"99999", "before its points"}},
      {"cut_in_a_record",
       [] {
         LasVlr vlr{"somebody", 7, "", Bytes(500, 1), false};
         return cut(point_file(with_vlr(las12(), vlr), kPoints), 400);
       },
       {"ends after 400 bytes", "before its points"}},
      {"unknown_format",
       [] { return patched<std::uint8_t>(point_file(las12(), 3), at::kFormat, 11); },
       {"point format 11", "0 to 10"}},
      {"short_records",
       [] { return patched<std::uint16_t>(point_file(las12(), 3), at::kRecordBytes, 20); },
       {"20 bytes", "needs 28"}},
      {"scale_nan",
       [] { return patched(point_file(las12(), 3), at::kScaleX, std::nan("")); },
       {"scale nan", "byte 131"}},
      {"scale_0",
       [] { return patched(point_file(las12(), 3), at::kScaleX + 8, 0.0); },
       {"scale 0 for y"}},
      {"scale_huge",
       [] { return patched(point_file(las12(), 3), at::kScaleX + 16, 1e30); },
       {"scale 1e+30 for z"}},
      {"scale_negative",
       [] { return patched(point_file(las12(), 3), at::kScaleX, -0.01); },
       {"scale -0.01"}},
      {"offset_infinite",
       [] {
         return patched(point_file(las12(), 3), at::kOffsetX,
                        std::numeric_limits<double>::infinity());
       },
       {"offset inf", "byte 155"}},
  };
}

std::vector<BadFile> bad_points() {
  return {
      {"las_cut",
       [] { return cut(point_file(las12(), kPoints), 10000); },
       {"1000 points", "room for", "download"}},
      {"las_count_too_large",
       [] {
         return patched<std::uint32_t>(point_file(las12(), kPoints), at::kLegacyCount, 4000000);
       },
       {"4000000 points", "room for 1000"}},
      {"las14_count_absurd",
       [] { return patched<std::uint64_t>(point_file(las14(), kPoints), at::kCount, ~0ull / 3); },
       {"room for 1000"}},
      {"laz_cut",
       [] {
         const Bytes whole = point_file(laz(6), kPoints);
         return cut(whole, whole.size() / 2);
       },
       {"chunk table", "cut short"}},
      {"laz_cut_at_points",
       [] {
         const Bytes whole = point_file(laz(1), kPoints);
         return cut(whole, points_at(whole) + 4);
       },
       {"before its first point"}},
      {"laz_chunk_table_missing",
       [] {
         const Bytes whole = point_file(laz(1), kPoints);
         return patched<std::uint64_t>(whole, points_at(whole), points_at(whole));
       },
       {"no chunk table", "interrupted"}},
      {"laz_chunk_table_elsewhere",
       [] {
         const Bytes whole = point_file(laz(6), kPoints);
         return patched<std::uint64_t>(whole, points_at(whole), points_at(whole) + 1000);
       },
       {"chunk table"}},
      {"laz_count_too_large",
       [] { return patched<std::uint64_t>(point_file(laz(6), kPoints), at::kCount, 5000); },
       {"5000 points"}},
      {"laz_mark_without_record",
       [] { return patched<std::uint8_t>(point_file(las12(), 3), at::kFormat, 0x81); },
       {"LASzip record"}},
      {"laz_unknown_compressor",
       [] {
         const Bytes whole = point_file(laz(6), kPoints);
         return patched<std::uint16_t>(whole, laszip_record(whole, 0), 9);
       },
       {"compressor 9", "22204"}},
      {"laz_items_of_another_format",
       [] {
         const Bytes whole = point_file(laz(6), kPoints);
         return patched<std::uint16_t>(whole, laszip_record(whole, 34), 6);
       },
       {"point format 6"}},
      {"laz_layer_sizes_absurd",
       [] {
         const Bytes whole = point_file(laz(6), kPoints);
         return patched<std::uint32_t>(whole, points_at(whole) + 8 + 30 + 4, 0xf0000000u);
       },
       {"chunk at byte", "claims"}},
  };
}

class BadFiles : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadFiles, EndInOneClearLine) {
  const TemporaryFolder folder;
  const auto path = folder / "bad.laz";
  write_file(path, GetParam().bytes());
  expect_clear_line(read_error(path), path, GetParam().words);
}

const auto kName = [](const ::testing::TestParamInfo<BadFile>& info) {
  return std::string(info.param.name);
};
INSTANTIATE_TEST_SUITE_P(Headers, BadFiles, ::testing::ValuesIn(bad_headers()), kName);
INSTANTIATE_TEST_SUITE_P(Points, BadFiles, ::testing::ValuesIn(bad_points()), kName);

class BadPoints : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadPoints, AreDescribedByTheInfoWithoutAnErrorWhereOnlyTheyAreBad) {
  const TemporaryFolder folder;
  const auto path = folder / "bad.laz";
  write_file(path, GetParam().bytes());
  try {
    const LasInfo info = read_las_info(path);
    LasReadOptions options{.attributes = Attribute::kAll};
    options.keep_readable_part = true;
    const LasReadResult result = read_las(info, options);
    EXPECT_NE(result.problem, "");
    EXPECT_EQ(result.points.size(), result.points_decoded);
    EXPECT_LE(result.points.size(), kPoints);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("LASzip record"));
  }
}
INSTANTIATE_TEST_SUITE_P(Points, BadPoints, ::testing::ValuesIn(bad_points()), kName);

TEST(BadPlaces, AFolderAMissingFileAndADeviceAreToldApart) {
  const TemporaryFolder folder;
  expect_clear_line(read_error(folder.path()), folder.path(), {"is a folder"});
  expect_clear_line(read_error(folder / "none.laz"), folder / "none.laz",
                    {"No such file", "check the path"});
  expect_clear_line(read_error("/dev/null"), "/dev/null", {"no regular file"});
}

TEST(ReadablePart, IsEveryWholeRecordOfACutLasFile) {
  const TemporaryFolder folder;
  const auto path = folder / "cut.las";
  const Bytes whole = point_file(las12(), kPoints);
  write_file(path, cut(whole, 227 + 28 * 700 + 13));
  LasReadOptions options{.attributes = Attribute::kAll};
  options.keep_readable_part = true;
  const LasReadResult result = read_las(read_las_info(path), options);
  EXPECT_EQ(result.points.size(), 700u);
  EXPECT_EQ(result.points.exact.back(), sample_cloud(kPoints, las12(), 1).exact[699]);
  EXPECT_THAT(result.problem, HasSubstr("1000 points"));
}

TEST(ReadablePart, OfLazWithoutItsChunkTableIsEverything) {
  const TemporaryFolder folder;
  for (const int format : {1, 6}) {
    const auto path = folder / "no_table.laz";
    const Bytes whole = point_file(laz(format), kPoints);
    write_file(path, patched<std::uint64_t>(whole, points_at(whole), points_at(whole)));
    for (const int threads : {1, 2}) {
      LasReadOptions options{.attributes = Attribute::kAll, .threads = threads};
      options.keep_readable_part = true;
      const LasReadResult result = read_las(read_las_info(path), options);
      EXPECT_EQ(result.points.exact, sample_cloud(kPoints, laz(format), 1).exact);
      EXPECT_THAT(result.problem, HasSubstr("no chunk table"));
    }
  }
}

TEST(ReadablePart, EndsBeforeTheFirstDamagedChunkWithAnyNumberOfThreads) {
  const TemporaryFolder folder;
  const auto path = folder / "damaged.laz";
  Bytes file = point_file(laz(6), kPoints);
  write_file(path, file);
  const LasInfo info = read_las_info(path);
  const auto table_at = static_cast<std::size_t>(load_le<std::uint64_t>(file, points_at(file)));
  const auto table = decode_chunk_table(std::span(file).subspan(table_at), false, 10);
  ASSERT_TRUE(table);
  std::size_t third = points_at(file) + 8 + (*table)[0].bytes + (*table)[1].bytes;
  store_le<std::uint32_t>(file, third + 30 + 4, 0x7fffffffu);
  write_file(path, file);
  for (const int threads : {1, 2, 3}) {
    LasReadOptions options{.attributes = Attribute::kAll, .threads = threads};
    EXPECT_THROW(read_las(info, options), InputError);
    options.keep_readable_part = true;
    const LasReadResult result = read_las(info, options);
    EXPECT_EQ(result.points.size(), 200u);
    EXPECT_THAT(result.problem, HasSubstr("points 200 to 299"));
  }
}

TEST(ReadablePart, EndsWhereAChunkBeginsWithBytesThatNoCoderWrites) {
  const TemporaryFolder folder;
  const auto path = folder / "impossible.laz";
  for (const int format : {1, 6}) {
    const Bytes whole = point_file(laz(format), kPoints);
    // Behind the first record; of layered chunks also behind their number and nine sizes.
    const std::size_t coded = points_at(whole) + 8 + (format == 1 ? 28 : 30 + 4 + 9 * 4);
    write_file(path, patched<std::uint32_t>(whole, coded, 0xffffffffu));
    EXPECT_THAT(read_error(path), HasSubstr("is damaged"));
  }
}

TEST(HostileHeaders, AnAbsurdCountOfPointsDoesNotTakeMemory) {
  const TemporaryFolder folder;
  const auto path = folder / "hostile.laz";
  Bytes file = point_file(laz(1), kPoints);
  // One chunk of 4 thousand million points, with a table that agrees.
  store_le<std::uint32_t>(file, laszip_record(file, 12), 0xfffffff0u);
  store_le<std::uint32_t>(file, at::kLegacyCount, 0xfffffff0u);
  const auto table_at = static_cast<std::size_t>(load_le<std::uint64_t>(file, points_at(file)));
  const std::vector<LazChunk> one{{0, static_cast<std::uint32_t>(table_at - points_at(file) - 8)}};
  const Bytes table = encode_chunk_table(one, false);
  file.resize(table_at);
  file.insert(file.end(), table.begin(), table.end());
  write_file(path, file);
  const std::uint64_t before = peak_resident_bytes();
  LasReadOptions options{.attributes = Attribute::kAll};
  options.keep_readable_part = true;
  const LasReadResult result = read_las(read_las_info(path), options);
  EXPECT_NE(result.problem, "");
  EXPECT_LT(result.points.size(), 1'000'000u);
  EXPECT_LT(peak_resident_bytes() - before, 300ull << 20);
}

TEST(HostileHeaders, ACountOfRecordsThatCannotBeIsAWarning) {
  const TemporaryFolder folder;
  const auto path = folder / "a.las";
  write_file(path, patched<std::uint32_t>(point_file(las12(), kPoints), at::kVlrCount, 1069128089));
  const LasInfo info = read_las_info(path);
  EXPECT_THAT(info.warnings, ::testing::ElementsAre(HasSubstr("1069128089 records, only 0 fit")));
  EXPECT_EQ(read_las(info, {}).points.size(), kPoints);
}

TEST(HeaderBounds, ThatAreNotThoseOfThePointsAreAWarningAndCostNoPrecision) {
  const TemporaryFolder folder;
  const auto path = folder / "a.las";
  LasWriteOptions options = las12();
  options.offset = {2'700'000.0, 1'200'000.0, 0.0};
  const Bytes whole = point_file(options, kPoints);
  write_file(path, whole);
  EXPECT_TRUE(read_las(read_las_info(path), {}).warnings.empty());
  write_file(path, patched(whole, at::kMinX, 12.0));
  const LasReadResult result = read_las(read_las_info(path), {.attributes = Attribute::kExact});
  EXPECT_THAT(result.warnings, ::testing::ElementsAre(HasSubstr("bounds")));
  const double x = result.points.exact[5].x * 0.01 + 2'700'000.0;
  EXPECT_NEAR(result.points.position(5).x, x, 1e-3);
}

TEST(Zip, WithOneLasOrLazIsReadAsItIs) {
  const TemporaryFolder folder;
  for (const bool compress : {false, true}) {
    LasWriteOptions options = laz(1);
    options.compress = compress;
    const auto path = folder / (compress ? "b.laz.zip" : "a.las.zip");
    write_zip(path, {{"readme.txt", text("hello")}, {"tile.las", point_file(options, kPoints)}});
    const LasInfo info = read_las_info(path);
    EXPECT_TRUE(info.zipped);
    EXPECT_EQ(info.zip_member, "tile.las");
    for (const int threads : {1, 2}) {
      LasReadOptions read{.attributes = Attribute::kAll, .threads = threads};
      EXPECT_EQ(read_las(info, read).points.exact, sample_cloud(kPoints, options, 1).exact);
    }
  }
}

TEST(Zip, WithSeveralOrNoPointFilesOrDamagedEndsInOneClearLine) {
  const TemporaryFolder folder;
  const Bytes las = point_file(las12(), kPoints);
  write_zip(folder / "two.zip", {{"a.las", las}, {"b.LAZ", las}});
  expect_clear_line(read_error(folder / "two.zip"), folder / "two.zip", {"2 .las or .laz"});
  write_zip(folder / "none.zip", {{"readme.txt", text("hello")}});
  expect_clear_line(read_error(folder / "none.zip"), folder / "none.zip", {"0 .las or .laz"});
  write_zip(folder / "one.zip", {{"a.las", las}});
  Bytes damaged = read_file(folder / "one.zip");
  for (std::size_t i = 5000; i < 6000; ++i) damaged[i] = 0x55;
  write_file(folder / "damaged.zip", damaged);
  expect_clear_line(read_error(folder / "damaged.zip"), folder / "damaged.zip", {"damaged"});
  write_file(folder / "cut.zip", cut(read_file(folder / "one.zip"), 3000));
  expect_clear_line(read_error(folder / "cut.zip"), folder / "cut.zip", {".zip"});
}

}  // namespace
}  // namespace cornice::test
