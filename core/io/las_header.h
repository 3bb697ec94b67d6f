// SPDX-License-Identifier: GPL-3.0-or-later
// The header of a LAS file and its records, parsed strictly from bytes that may be hostile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/io/byte_source.h"
#include "core/io/las.h"

namespace cornice {

/// Bytes before the data of a variable-length record, and of an extended one.
inline constexpr std::size_t kVlrHeaderBytes = 54;
inline constexpr std::size_t kEvlrHeaderBytes = 60;

/// Bytes of a record of point format 0-10 without extra bytes (LAS 1.4 R15, tables 7-17).
std::size_t las_base_record_bytes(int point_format);

/// Parses header, VLRs and EVLRs. The CRS is left empty. `name` goes into errors.
/// Allocates no more than the source's size for records, whatever the header claims.
/// Throws InputError where the bytes are no LAS, end inside the header or a record, or contradict
/// themselves.
LasInfo parse_las(ByteSource& source, const std::string& name);

/// Appends the records between the header's end and the points to info.vlrs.
void parse_vlrs(ByteSource& source, const std::string& name, std::size_t header_bytes,
                std::uint32_t claimed, LasInfo& info);

/// Appends the extended records; those that do not fit the file become warnings.
void parse_evlrs(ByteSource& source, std::uint64_t start, std::uint32_t claimed, LasInfo& info);

/// Fills info.extra_bytes from the record LASF_Spec 4, as far as it fits info.extra_stride.
void parse_extra_bytes(LasInfo& info);

/// The first record of that user and id that has data, or null.
const LasVlr* find_vlr(const LasInfo& info, const std::string& user_id, std::uint16_t record_id);

}  // namespace cornice
