/* -- opening and closing ---------------------------------------------------------------------------

   A file is mapped where the system can do that, and read into memory otherwise. */

#ifdef RBTI_MMAP

RBT_API int rbt_open(const char *path, rbt_table **table)
{
    RBTI_REQUIRE(table, RBT_ERR_MISSING);
    *table = NULL;
    RBTI_REQUIRE(path, RBT_ERR_MISSING);
    const int file = open(path, O_RDONLY | O_NONBLOCK); /* opening a pipe would wait for its writer */
    if (file < 0)
        return RBT_ERR_NOT_OPENED;
    struct stat about;
    if (fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) {
        close(file);
        return RBT_ERR_NOT_READ;
    }
    /* compared as 64 bits, since off_t has 32 bits on some machines */
    if (about.st_size <= 0 || (uint64_t)about.st_size >= RBTI_MOST_BYTES) {
        close(file);
        return about.st_size <= 0 ? RBT_ERR_FORMAT : RBT_ERR_SIZE;
    }
    const size_t size = (size_t)about.st_size;
    void *image = mmap(NULL, size, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    if (image == MAP_FAILED)
        return RBT_ERR_NOT_READ;
    const int code = rbt_open_memory(image, size, table);
    if (code == RBT_OK)
        (*table)->to_unmap = image;
    else
        munmap(image, size);
    return code;
}

#else

/* Read a whole file to an address that is a multiple of 64. */
static int rbti_read_file(FILE *file, void **memory, char **image, size_t *size)
{
    if (fseek(file, 0, SEEK_END) != 0)
        return RBT_ERR_NOT_READ;
    const long end = ftell(file);
    if (end < 0 || fseek(file, 0, SEEK_SET) != 0)
        return RBT_ERR_NOT_READ;
    if ((unsigned long)end >= RBTI_MOST_BYTES)
        return RBT_ERR_SIZE;
    *size = (size_t)end;
    *memory = RBT_MALLOC(*size + 64);
    if (!*memory)
        return RBT_ERR_NO_MEMORY;
    *image = (char *)*memory + (64 - (uintptr_t)*memory % 64) % 64;
    return fread(*image, 1, *size, file) == *size ? RBT_OK : RBT_ERR_NOT_READ;
}

RBT_API int rbt_open(const char *path, rbt_table **table)
{
    RBTI_REQUIRE(table, RBT_ERR_MISSING);
    *table = NULL;
    RBTI_REQUIRE(path, RBT_ERR_MISSING);
#ifdef RBTI_POSIX
    struct stat about; /* opening a pipe would wait for its writer */
    if (stat(path, &about) == 0 && !S_ISREG(about.st_mode))
        return RBT_ERR_NOT_READ;
#endif
    FILE *file = fopen(path, "rb");
    if (!file)
        return RBT_ERR_NOT_OPENED;
    void *memory = NULL;
    char *image = NULL;
    size_t size = 0;
    int code = rbti_read_file(file, &memory, &image, &size);
    fclose(file);
    if (code == RBT_OK)
        code = rbt_open_memory(image, size, table);
    if (code == RBT_OK)
        (*table)->to_free = memory;
    else
        RBT_FREE(memory);
    return code;
}

#endif

RBT_API void rbt_close(rbt_table *table)
{
    if (!table)
        return;
#ifdef RBTI_MMAP
    if (table->to_unmap)
        munmap(table->to_unmap, table->image_size);
#endif
    RBT_FREE(table->to_free);
    RBT_FREE(table);
}

RBT_API const char *rbt_strerror(int code)
{
    static const struct {
        int code;
        const char *text;
    } texts[] = {
/* begin texts */
        {RBT_OK, "no error"},
        {RBT_ANGLE, "the impact angle lies outside the table, and the nearest angle"
         " was used"},
        {RBT_SPEED, "the impact speed lies outside the table, and the nearest speed"
         " was used"},
        {RBT_SPIN, "the spin lies outside the table, or the grain cannot have this"
         " inertia, and the nearest value was used"},
        {RBT_EXTRAPOLATED, "the material pair was not measured at this speed"},
        {RBT_ERR_MISSING, "the table (NULL, or a handle of 0) or a required array is "
         "missing: a rebound needs velocity, normal, half_size, index "
         "and hit, a draw needs alpha1, speed, index and hit"},
        {RBT_ERR_NOT_FINITE, "an argument, or the square of a speed or a spin, is NaN or "
         "infinite; or an inertia is negative"},
        {RBT_ERR_NOT_APPROACHING, "the particle moves away from the wall, or alpha1 is not above "
         "0 and at most pi/2 rad; leave its velocity unchanged; if every"
         " particle has this code, the normals point into the wall"},
        {RBT_ERR_SPEED_NOT_POSITIVE,
         "the impact speed is not above 0, or the particle moves at less"
         " than 1e-150 m/s relative to the wall"},
        {RBT_ERR_NORMAL_NOT_USABLE, "the normal of the wall has length zero"},
        {RBT_ERR_HALF_SIZE, "the half-size is not from 1e-09 to 100 m"},
        {RBT_ERR_ROUGHNESS_NOT_USABLE,
         "the roughness is not from 0 to 0.5 rad, or there is no such "
         "profile: ra must be 0 or more, rq not below ra, rsm and "
         "diameter above 0"},
        {RBT_ERR_CASCADE_NOT_ENDED,
         "the particle hit facet after facet of the rough wall and did "
         "not leave it"},
        {RBT_ERR_REBOUND_NOT_ENDED, "the simulated particle did not leave the wall; a larger "
         "contact_resolution ends a chain of collisions"},
        {RBT_ERR_NO_SPIN_LAW, "the table has no spin law; ask for fresh grains that arrive "
         "without spin"},
        {RBT_ERR_GRAIN_NOT_KNOWN, "the table was not made for this grain: a shape, b/a or c/b is "
         "not one of its population"},
        {RBT_ERR_NO_WORKS, "the table does not have the energies that impulses take "
         "(works)"},
        {RBT_ERR_DIRECT_VERSION, "the object of direct simulation was made for another version "
         "of this header; write it again: tablegen export-direct"},
        {RBT_ERR_DIRECT_PAIR, "the object of direct simulation is of another material pair "
         "than the table, or lacks a shape of its grains"},
        {RBT_ERR_NOT_OPENED, "the file does not exist, or may not be read"},
        {RBT_ERR_NOT_READ, "the file cannot be read; it must be a regular file, not a "
         "folder, pipe or device"},
        {RBT_ERR_NO_MEMORY, "there is not enough memory for this table"},
        {RBT_ERR_BIG_ENDIAN, "this machine is big-endian, and tables are little-endian"},
        {RBT_ERR_FORMAT, "the file is not a binary rebound table (.rbt)"},
        {RBT_ERR_VERSION, "the file has a format, or a spin law, of another version; "
         "write it again: sampler export"},
        {RBT_ERR_SIZE, "the file is damaged: it has not the length that its header "
         "states"},
        {RBT_ERR_CHECKSUM, "the file is damaged: its contents do not have its checksum"},
        {RBT_ERR_DIMENSIONS, "the file is damaged: a dimension is 0 or too large, or does "
         "not fit the others"},
        {RBT_ERR_NAMES, "the file is damaged: a channel or variable is unknown or "
         "occurs twice"},
        {RBT_ERR_OFFSETS, "the file is damaged: an array does not lie within it, at a "
         "multiple of 64"},
        {RBT_ERR_INDICES, "the file is damaged: a component, class, root or child lies "
         "beyond its array"},
        {RBT_ANGLE | RBT_SPEED, "the impact angle lies outside the table, and the nearest angle"
         " was used; the impact speed lies outside the table, and the "
         "nearest speed was used"},
        {RBT_ANGLE | RBT_SPIN, "the impact angle lies outside the table, and the nearest angle"
         " was used; the spin lies outside the table, or the grain "
         "cannot have this inertia, and the nearest value was used"},
        {RBT_ANGLE | RBT_EXTRAPOLATED,
         "the impact angle lies outside the table, and the nearest angle"
         " was used; the material pair was not measured at this speed"},
        {RBT_SPEED | RBT_SPIN, "the impact speed lies outside the table, and the nearest speed"
         " was used; the spin lies outside the table, or the grain "
         "cannot have this inertia, and the nearest value was used"},
        {RBT_SPEED | RBT_EXTRAPOLATED,
         "the impact speed lies outside the table, and the nearest speed"
         " was used; the material pair was not measured at this speed"},
        {RBT_SPIN | RBT_EXTRAPOLATED,
         "the spin lies outside the table, or the grain cannot have this"
         " inertia, and the nearest value was used; the material pair "
         "was not measured at this speed"},
        {RBT_ANGLE | RBT_SPEED | RBT_SPIN,
         "the impact angle lies outside the table, and the nearest angle"
         " was used; the impact speed lies outside the table, and the "
         "nearest speed was used; the spin lies outside the table, or "
         "the grain cannot have this inertia, and the nearest value was "
         "used"},
        {RBT_ANGLE | RBT_SPEED | RBT_EXTRAPOLATED,
         "the impact angle lies outside the table, and the nearest angle"
         " was used; the impact speed lies outside the table, and the "
         "nearest speed was used; the material pair was not measured at "
         "this speed"},
        {RBT_ANGLE | RBT_SPIN | RBT_EXTRAPOLATED,
         "the impact angle lies outside the table, and the nearest angle"
         " was used; the spin lies outside the table, or the grain "
         "cannot have this inertia, and the nearest value was used; the "
         "material pair was not measured at this speed"},
        {RBT_SPEED | RBT_SPIN | RBT_EXTRAPOLATED,
         "the impact speed lies outside the table, and the nearest speed"
         " was used; the spin lies outside the table, or the grain "
         "cannot have this inertia, and the nearest value was used; the "
         "material pair was not measured at this speed"},
        {RBT_ANGLE | RBT_SPEED | RBT_SPIN | RBT_EXTRAPOLATED,
         "the impact angle lies outside the table, and the nearest angle"
         " was used; the impact speed lies outside the table, and the "
         "nearest speed was used; the spin lies outside the table, or "
         "the grain cannot have this inertia, and the nearest value was "
         "used; the material pair was not measured at this speed"},
/* end texts */
    };
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++)
        if (texts[k].code == code)
            return texts[k].text;
    return "unknown code";
}

#endif
