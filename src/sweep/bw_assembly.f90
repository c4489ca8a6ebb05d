module bw_assembly
  !! The result of a sweep from the journals of all its cases, by NetCDF alone.
  use bw_case_fields, only: blocks_for, case_block, field_of, fields_of
  use bw_case_result, only: case_done
  use bw_error, only: error_type, fail, status_bad_file
  use bw_journal_reader, only: journal_reader
  use bw_kinds, only: dp, i1, i8
  use bw_notes, only: notes_type
  use bw_pooled_table, only: pooled_table
  use bw_pooled_variables, only: put_pooled
  use bw_repeat_cases, only: repeat_cases
  use bw_repeats, only: pooled_lines
  use bw_result_file, only: create_result, result_file
  use bw_result_layout, only: has, result_layout
  use bw_scene, only: scene_type
  use bw_sweep_table, only: sweep_table
  use bw_text, only: string, text_of
  implicit none (type, external)
  private

  type, public :: assembly_type
    !! A sweep's result, and what there is to say of it.
    type(notes_type) :: notes
    integer(i8) :: not_trusted = 0                       !! cases
    character(:), allocatable :: report                  !! the table of cases; once it is finished
    type(scene_type), private :: scene
    type(sweep_table), private :: table
    type(repeat_cases), allocatable, private :: repeats  !! unallocated: cases are no repeats of one measurement
    type(result_file), private :: file
    integer(i8), private :: at_status = 0                !! where a case's status stands among its numbers
    integer(i1), allocatable, private :: done(:)         !! (cases) 1: it is in the file
    type(case_block), private :: blocks(2)               !! of neighbouring cases, what is not written yet
  contains
    procedure :: begin
    procedure :: take_journal
    procedure :: finish
    procedure, private :: take_case
  end type assembly_type

contains

  subroutine begin(self, path, scene, layout, error)
    !! Create a result without cases.
    class(assembly_type), intent(inout) :: self
    character(*), intent(in) :: path                     !! where it is made
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(error_type), allocatable, intent(out) :: error
    call create_result(path, scene, layout, self%file, error)
    self%blocks = blocks_for(fields_of(layout), layout%cases)
    associate (status => field_of(fields_of(layout), 'case_status'))
      self%at_status = status%first
    end associate
    self%scene = scene
    self%table = sweep_table(layout)
    if (has(layout, 'pooled')) self%repeats = repeat_cases(scene, layout)
    allocate (self%done(layout%cases), source=0_i1)
  end subroutine begin

  subroutine take_journal(self, path, work, error)
    !! Read a journal, and put all of its cases that are not there yet into the result: whoever did one, it has the same bits.
    !! **Errors**: the journal cannot be read, or the result not written.
    class(assembly_type), intent(inout) :: self
    character(*), intent(in) :: path
    integer(i8), intent(in) :: work                      !! sum of the text of the work that the cases have to belong to
    type(error_type), allocatable, intent(inout) :: error
    type(journal_reader) :: reader
    logical :: found
    call reader%open(path, error)
    do
      call reader%next(found, error)
      if (.not. found) exit
      if (reader%work /= work .or. reader%case < 1 .or. reader%case > size(self%done, kind=i8)) cycle
      if (self%done(reader%case) == 0) call self%take_case(reader%case, reader%numbers, reader%notes, error)
    end do
    call reader%close()
  end subroutine take_journal

  subroutine take_case(self, index, numbers, notes, error)
    !! Put a case into the result: into the blocks of its neighbours, which are written when they are full, or do not reach up
    !! to this case.
    class(assembly_type), intent(inout) :: self
    integer(i8), intent(in) :: index
    real(dp), intent(in), contiguous :: numbers(:)
    type(string), intent(in) :: notes(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    do i = 1, size(self%blocks)
      if (.not. self%blocks(i)%takes(index)) call self%file%put_cases(self%blocks(i), error)
      call self%blocks(i)%add(index, numbers)
    end do
    if (nint(numbers(self%at_status)) /= case_done) self%not_trusted = self%not_trusted + 1
    self%done(index) = 1_i1
    call self%notes%add(index, notes)
    call self%table%add(index, numbers)
    if (allocated(self%repeats)) call self%repeats%add(index, numbers)
  end subroutine take_case

  subroutine finish(self, notes, seconds, error)
    !! Put what repeats share, the notes, the report and the times of the stages, and close the file.
    !! **Errors**: cases are missing, or the file cannot be written.
    class(assembly_type), intent(inout) :: self
    character(*), intent(in) :: notes
    real(dp), intent(in) :: seconds(:)                   !! (stages)
    type(error_type), allocatable, intent(inout) :: error
    type(pooled_lines) :: pooled
    integer :: i
    do i = 1, size(self%blocks)
      call self%file%put_cases(self%blocks(i), error)
    end do
    self%report = self%table%text(self%scene)
    if (allocated(self%repeats)) then
      pooled = self%repeats%pooled(self%scene)
      self%report = self%report//pooled_table(pooled, size(self%done), self%scene%spectrum%confidence)
      call put_pooled(self%file, pooled, error)
    end if
    if (allocated(error)) return
    if (any(self%done == 0)) then
      call fail(error, status_bad_file, text_of(count(self%done == 0))//' finished cases cannot be found in their journals '// &
                'any more; the same command does them again')
    else
      call self%file%finish(notes, self%report, seconds, error)
    end if
  end subroutine finish

end module bw_assembly
