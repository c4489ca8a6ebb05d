module bw_result_draft
  !! The draft of a result: one classic NetCDF file in which every number has a fixed place before any case is run. The
  !! processes of a host put their cases directly into it. A case is done when it has a status, which is put after its
  !! numbers are on the disk.
  use bw_case_result, only: case_done, case_not_converged, case_result, case_words
  use bw_case_rows, only: case_rows
  use bw_error, only: error_type
  use bw_file_rows, only: add_dimensions, coordinate_rows, end_rows, input_rows, swept_names
  use bw_files, only: cannot_be_read, cannot_be_written, remove_file
  use bw_kinds, only: dp, i1, i8
  use bw_number_file, only: whole_width
  use bw_over_cases, only: over_cases
  use bw_result_header, only: history_text, put_attributes, time_stamp
  use bw_result_layout, only: result_layout
  use bw_result_supplement, only: result_supplement
  use bw_result_table, only: after_cases, before_cases, of_case_ends, of_cases, of_notes, of_supplement, result_table
  use bw_scene, only: scene_type
  use bw_stopwatch, only: stage_count
  use bw_text, only: append, fitted, lines_of, string
  implicit none (type, external)
  private

  integer, parameter, public :: not_done = -1        !! status of an unfinished case
  integer, parameter :: at_once = 4096               !! statuses in memory

  type, extends(result_table), public :: result_draft
    type(scene_type) :: scene
    character(:), allocatable, private :: head_bytes  !! of a file of this layout, without its texts
    integer, private :: status = 0, notes = 0         !! variables
  contains
    procedure :: plan
    procedure :: create
    procedure :: open => open_draft
    procedure :: host, put_case, put_statuses, get_statuses, find_notes, get_notes, take_cases, finish
  end type result_draft

contains

  subroutine plan(self, scene, layout, supplement)
    !! Define the file of a result.
    class(result_draft), intent(inout) :: self
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    class(result_supplement), intent(in), optional :: supplement
    type(result_table) :: table
    type(case_result) :: none
    real(dp) :: seconds(stage_count)
    type(over_cases) :: nothing
    logical :: fits, ignored
    seconds = 0
    self%scene = scene
    do
      self%result_table = table
      self%layout = layout
      self%layout%modelled = present(supplement)
      self%swept = swept_names(scene)
      call put_attributes(self%head, scene)
      if (allocated(layout%record)) call self%head%add_text('record_checksum', layout%record%checksums, of_file=.true.)
      if (allocated(layout%load_checksums)) call self%head%add_text('load_checksum', layout%load_checksums, of_file=.true.)
      if (present(supplement)) call supplement%attributes(self%head)
      call add_dimensions(self%layout, self%head)
      call self%begin_section(before_cases)
      call coordinate_rows(self, scene)
      call input_rows(self, scene)
      call self%begin_section(of_cases)
      call case_rows(self, none)
      call self%begin_section(of_case_ends)
      ignored = self%whole_row('case_status', '', 'how the case ended', case_words)      ! put by `put_statuses`
      call self%begin_section(after_cases)
      call end_rows(self, seconds, nothing)
      call self%begin_section(of_supplement)
      if (present(supplement)) call supplement%rows(self)
      call self%begin_section(of_notes)
      ignored = self%text_row('notes', 'note_letter', 'what there is to say of the case, a line for each note', needs='case')
      call self%lay_out(self%head_bytes, fits)
      if (fits) exit
      table%head%width = 8
    end do
    self%status = self%variable('case_status')
    self%notes = self%variable('notes')
  end subroutine plan

  subroutine create(self, path, error)
    !! Create a draft with all values known before any case is run.
    !! **Errors**: the disk is full, or the system refuses it.
    class(result_draft), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    integer(i8) :: reserved
    integer :: ignored, i, n
    reserved = self%head%bytes
    if (self%notes > 0) reserved = self%head%variables(self%notes)%place       ! few cases have notes
    call self%file%make(path, self%head%bytes, reserved, error)
    if (allocated(error)) return
    call self%begin_section(before_cases)
    call coordinate_rows(self, self%scene)
    call input_rows(self, self%scene)
    do i = 1, max(1, self%layout%cases), at_once
      n = min(at_once, max(1, self%layout%cases) - i + 1)
      call self%file%put_numbers(self%place_of(self%status, int(i, i8)), whole_width, spread(real(not_done, dp), 1, n))
    end do
    if (self%layout%cases > 0) call self%file%flush(error)      ! before the head makes it a draft, without finished cases
    call self%file%put_text(0_i8, self%head_bytes)
    call self%set_text('history', history_text(self%scene))
    call self%file%write()
    if (self%file%problem /= 0) call cannot_be_written(error, path, self%file%problem)
    if (.not. allocated(error)) return
    call self%file%close()
    ignored = remove_file(path)
  end subroutine create

  subroutine open_draft(self, path, shared, is_ours, error)
    !! Open an existing draft of this layout: with the same length, and the same head to the byte except texts that
    !! change. **Errors**: the system refuses it.
    class(result_draft), intent(inout) :: self
    character(*), intent(in) :: path
    logical, intent(in) :: shared                     !! other processes put cases between those of this one
    logical, intent(out) :: is_ours
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: there
    integer(i8) :: bytes
    is_ours = .false.
    allocate (character(len(self%head_bytes)) :: there)
    call self%file%open(path, shared, bytes, error)
    if (allocated(error)) return
    if (bytes == self%head%bytes) then
      call self%file%get_text(0_i8, there)
      call self%head%blank_texts(there)
      is_ours = there == self%head_bytes
    end if
    if (self%file%problem /= 0) call cannot_be_read(error, path, self%file%problem)
    if (allocated(error) .or. .not. is_ours) call self%file%close()
  end subroutine open_draft

  function host(self) result(name)
    !! Return the host on which the draft was made.
    class(result_draft), intent(inout) :: self
    character(:), allocatable :: name
    call self%get_text('history', name)
    name = name(index(name, ' ') + 1:index(name, ': ') - 1)
  end function host

  subroutine put_case(self, case, result)
    !! Put the numbers of a case, and its notes. This is the last check: a case with NaN or infinity, which no stage
    !! should produce, is marked as not trusted and names the variable.
    class(result_draft), intent(inout) :: self
    integer(i8), intent(in) :: case
    type(case_result), intent(inout) :: result
    character(:), allocatable :: text
    integer :: i
    call self%begin_case(case, result%mode_count == 0 .and. .not. allocated(result%record))
    call case_rows(self, result)
    if (self%lost /= '') then
      if (result%status == case_done) result%status = case_not_converged
      call append(result%notes, 'not converged: rounding has left no numbers in '//self%lost(3:)//', which hold fill there. '// &
                  'This is a fault of the program: please report it with the scene')
      call self%put_again('note_count', [size(result%notes)])
    end if
    if (self%notes == 0 .or. size(result%notes) == 0) return
    text = result%notes(1)%text
    do i = 2, size(result%notes)
      text = text//new_line('a')//result%notes(i)%text
    end do
    call self%file%put_text(self%place_of(self%notes, case), fitted(text, self%length_of('note_letter')))
  end subroutine put_case

  subroutine put_statuses(self, cases, statuses)
    !! Put the statuses of cases whose numbers are on the disk.
    class(result_draft), intent(inout) :: self
    integer, intent(in) :: cases(:), statuses(:)
    integer :: i
    call self%write_cases()
    call self%file%hold()
    do i = 1, size(cases)
      call self%file%put_numbers(self%place_of(self%status, int(cases(i), i8)), whole_width, [real(statuses(i), dp)])
    end do
    call self%file%write()
  end subroutine put_statuses

  subroutine get_statuses(self, statuses)
    !! Get the statuses of all cases; `not_done` for unfinished ones or an invalid status.
    class(result_draft), intent(inout) :: self
    integer(i1), allocatable, intent(out) :: statuses(:)
    real(dp) :: values(at_once)
    integer :: first, n
    allocate (statuses(max(1, self%layout%cases)))
    do first = 1, size(statuses), at_once
      n = min(at_once, size(statuses) - first + 1)
      call self%get_column(self%status, 1, int(first, i8), values(:n))
      where (values(:n) >= size(case_words)) values(:n) = not_done
      statuses(first:first + n - 1) = int(max(not_done, nint(values(:n))), i1)
    end do
  end subroutine get_statuses

  subroutine find_notes(self, cases)
    !! List the cases with notes, ascending.
    class(result_draft), intent(inout) :: self
    integer, allocatable, intent(out) :: cases(:)
    real(dp) :: counts(at_once)
    integer :: first, n, i
    allocate (cases(0))
    do first = 1, self%layout%cases, at_once
      n = min(at_once, self%layout%cases - first + 1)
      call self%get_column(self%variable('note_count'), 1, int(first, i8), counts(:n))
      if (any(counts(:n) > 0)) cases = [cases, pack([(first + i - 1, i=1, n)], counts(:n) > 0)]
    end do
  end subroutine find_notes

  subroutine get_notes(self, case, notes)
    !! Get the notes of a case.
    class(result_draft), intent(inout) :: self
    integer(i8), intent(in) :: case
    type(string), allocatable, intent(out) :: notes(:)
    character(:), allocatable :: text
    integer :: last
    last = self%length_of('note_letter')
    allocate (character(last) :: text)
    call self%file%get_text(self%place_of(self%notes, case), text)
    last = index(text//char(0), char(0)) - 1
    notes = lines_of(text(:last))
  end subroutine get_notes

  subroutine take_cases(self, other, cases)
    !! Copy cases from another draft of the same layout, to which no process writes meanwhile.
    class(result_draft), intent(inout) :: self
    class(result_draft), intent(inout) :: other
    integer, intent(in) :: cases(:)                   !! ascending
    integer, allocatable :: noted(:)
    logical, allocatable :: is_taken(:)
    integer :: v, i, k
    do v = 1, self%head%count
      if (self%is_gathered(v)) call self%copy_rows(other, v, cases)
    end do
    call other%find_notes(noted)
    allocate (is_taken(size(noted)))
    k = 1
    do i = 1, size(noted)
      do while (k < size(cases))
        if (cases(k) >= noted(i)) exit
        k = k + 1
      end do
      is_taken(i) = any(cases(k:min(k, size(cases))) == noted(i))
    end do
    call self%copy_rows(other, self%notes, pack(noted, is_taken))
    if (self%file%problem == 0) self%file%problem = other%file%problem
  end subroutine take_cases

  subroutine finish(self, notes, report, seconds, over, error)
    !! Put values known when all cases are done, and flush the file to the disk.
    !! **Errors**: the system refuses it.
    class(result_draft), intent(inout) :: self
    character(*), intent(in) :: notes, report
    real(dp), intent(in) :: seconds(:)                !! (stages)
    type(over_cases), intent(in) :: over              !! empty for a single case
    type(error_type), allocatable, intent(inout) :: error
    call self%begin_section(after_cases)
    call end_rows(self, seconds, over)
    call self%set_text('notes', notes)
    call self%set_text('report', report)
    call self%set_text('created', time_stamp())
    call self%file%flush(error)
  end subroutine finish

end module bw_result_draft
