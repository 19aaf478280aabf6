/* Tables from an FMU's resources; a part of fmi_rest.h. */
#if WL_TABLES
#include "model_rows.h"

#ifdef _WIN32
#define SEPARATOR '\\'
#include <wchar.h>

/* Opens a file by its name in UTF-8, which Windows has in UTF-16. */
static FILE *opened(const char *path)
{
    wchar_t wide[4096];
    size_t used = 0;
    for (const unsigned char *c = (const unsigned char *)path; *c && used + 2 < 4096;) {
        unsigned code = *c++, more = code >= 0xf0 ? 3 : code >= 0xe0 ? 2 : code >= 0xc0 ? 1 : 0;
        code &= more == 3 ? 0x07 : more == 2 ? 0x0f : more == 1 ? 0x1f : 0x7f;
        for (; more && (*c & 0xc0) == 0x80; more--)
            code = code << 6 | (*c++ & 0x3f);
        if (code >= 0x10000)
            wide[used++] = (wchar_t)(0xd7c0 + (code >> 10));
        wide[used++] = (wchar_t)(code >= 0x10000 ? 0xdc00 + (code & 0x3ff) : code);
    }
    wide[used] = 0;
    return _wfopen(wide, L"rb");
}
#else
#define SEPARATOR '/'
#define opened(path) fopen(path, "rb")
#endif

static int hex(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* Path of a file of the resources, whose folder is given as a path or as a URI, file:///tmp/my%20fmu/resources. */
static void path_of(const char *folder, const char *file, char *path, size_t size)
{
    size_t used = 0;
    int uri = !strncmp(folder, "file:", 5);
    if (uri) {
        folder += 5;
        if (!strncmp(folder, "//", 2)) {
            const char *host = folder + 2;
            folder = !strncmp(host, "localhost/", 10) ? host + 9 : *host == '/' ? host : folder;
        }
        if (folder[0] == '/' && folder[1] && (folder[2] == ':' || folder[2] == '|')) /* /C:/ */
            folder++;
    }
    for (; *folder && used + 1 < size; folder++) {
        int coded = uri && *folder == '%' && hex(folder[1]) >= 0 && hex(folder[2]) >= 0;
        path[used++] = coded ? (char)(16 * hex(folder[1]) + hex(folder[2])) : *folder;
        folder += coded ? 2 : 0;
    }
    if (used && path[used - 1] != '/' && path[used - 1] != SEPARATOR && used + 1 < size)
        path[used++] = '/';
    snprintf(path + used, size - used, "%s", file);
}

/* The bytes of a file; NULL where it cannot be read. */
static unsigned char *bytes_of(const char *path, size_t *size)
{
    FILE *file = opened(path);
    unsigned char *bytes = NULL;
    long last = -1;
    if (file && !fseek(file, 0, SEEK_END) && (last = ftell(file)) > 0 && !fseek(file, 0, SEEK_SET)
        && (bytes = malloc((size_t)last))) {
        *size = (size_t)last;
        if (fread(bytes, 1, *size, file) != *size) {
            free(bytes);
            bytes = NULL;
        }
    }
    if (file)
        fclose(file);
    return bytes;
}

static void drop_tables(Model *model)
{
    for (int i = 0; i < WL_TABLES; i++) {
        free(model->tables[i].bytes);
        memset(&model->tables[i], 0, sizeof model->tables[i]);
    }
}

static int take_tables(Model *model, const char *folder)
{
    char path[4096];
    for (int i = 0; i < WL_TABLES; i++) {
        const Played *played = &WL(played)[i];
        const char *problem = "cannot be read; give the folder of the FMU's resources at instantiation";
        unsigned char *bytes = NULL;
        size_t size = 0;
        path_of(folder ? folder : "", played->file, path, sizeof path);
        if (folder && (bytes = bytes_of(path, &size)))
            problem = table_taken(&model->tables[i], played, bytes, size);
        if (problem) {
            if (!model->tables[i].bytes)
                free(bytes);
            model_report(model, "%s: %.300s: %s", played->part, path, problem);
            drop_tables(model);
            return 0;
        }
    }
    return 1;
}
#else
#define take_tables(model, folder) ((void)(folder), 1)
#define drop_tables(model) ((void)(model))
#endif
