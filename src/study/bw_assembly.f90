module bw_assembly
  !! The result of a sweep, put together by the leader while the cases are done. Numbers that are not written straight into
  !! their places come from the records of the cases. Until it is whole it counts for nothing: the records do.
  use bw_case_block, only: block_for, case_block
  use bw_case_result, only: case_done
  use bw_error, only: error_type
  use bw_kinds, only: dp, i1, i8
  use bw_notes, only: notes_type
  use bw_result_body, only: result_body
  use bw_result_file, only: create_result, open_result, result_file
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_sweep_table, only: sweep_table
  use bw_text, only: string
  use bw_unfinished, only: unfinished_work
  implicit none (type, external)
  private

  type, public :: assembly_type
    !! A sweep's result, and what there is to say of it.
    type(sweep_table) :: table
    type(notes_type) :: notes
    integer(i8) :: not_trusted = 0                       !! cases
    type(result_body) :: body
    integer(i1), allocatable :: done(:)                  !! (cases) 1: it is there
    type(result_file), private :: file                   !! open from the beginning where there is no body, else at the end
    type(case_block), private :: block                   !! neighbouring cases, not written yet
    integer(i8), private :: first = 1                    !! the first of them
    integer, private :: fields = 0                       !! how many are written by blocks: all, or those that are not long
  contains
    procedure :: begin
    procedure :: take
    procedure :: write_block
    procedure :: finish
    procedure :: abandon
    procedure, private :: add_to_table
  end type assembly_type

contains

  subroutine begin(self, scene, layout, unfinished, body, error)
    !! A result without cases.
    class(assembly_type), intent(inout) :: self
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(in) :: unfinished
    type(result_body), intent(in) :: body                !! where cases are written straight, if they are
    type(error_type), allocatable, intent(inout) :: error
    if (.not. body%known()) call create_result(unfinished%result_path(), scene, layout, self%file, error)
    if (allocated(error)) return
    self%body = body
    self%fields = merge(body%short, size(body%fields), body%known())
    self%block = block_for(body%fields(:self%fields), layout%cases)
    self%table = sweep_table(scene, layout)
    allocate (self%done(layout%cases), source=0_i1)
  end subroutine begin

  subroutine take(self, index, numbers, notes, error)
    !! A case, unless it is there: whoever did it, it has the same bits.
    class(assembly_type), intent(inout) :: self
    integer(i8), intent(in) :: index
    real(dp), intent(in), contiguous :: numbers(:)       !! all of it, or those that do not lie in their places already
    type(string), intent(in) :: notes(:)
    type(error_type), allocatable, intent(inout) :: error
    if (self%done(index) /= 0) return
    if (self%block%held == self%block%room .or. index /= self%first + self%block%held) then
      call self%write_block(error)                       ! it is full, or does not reach up to this case
      if (allocated(error)) return
      self%first = index
    end if
    associate (body => self%body)
      if (body%known() .and. size(numbers, kind=i8) == body%case_length()) call body%put_long_numbers(index, numbers, error)
      call self%block%add(body%fields(:self%fields), numbers)
      if (nint(numbers(body%short_length())) /= case_done) self%not_trusted = self%not_trusted + 1
    end associate
    self%done(index) = 1_i1
    call self%notes%add(index, notes)
    if (self%table%shows(index)) call self%add_to_table(index, numbers)
  end subroutine take

  subroutine add_to_table(self, index, numbers)
    !! A row of the printed table, which looks into the histories.
    class(assembly_type), intent(inout) :: self
    integer(i8), intent(in) :: index
    real(dp), intent(in), contiguous :: numbers(:)       !! as above
    real(dp), allocatable :: all_numbers(:)
    integer(i8) :: ignored
    logical :: done
    allocate (all_numbers(self%body%case_length()))
    done = .true.
    if (size(numbers) < size(all_numbers)) call self%body%get_long_numbers(index, all_numbers, ignored, done)
    all_numbers(:size(numbers)) = numbers
    if (done) call self%table%add(index, all_numbers)
  end subroutine add_to_table

  subroutine write_block(self, error)
    class(assembly_type), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    if (self%block%held > 0 .and. .not. allocated(error)) then
      if (self%body%known()) then
        call self%body%put_block(self%first, self%block, error)
      else
        call self%file%put_cases(self%first, self%block, error)
      end if
    end if
    self%block%held = 0
  end subroutine write_block

  subroutine finish(self, unfinished, notes, seconds, error)
    !! The result has all of its cases: notes and stage times, and it is closed.
    class(assembly_type), intent(inout) :: self
    type(unfinished_work), intent(in) :: unfinished
    character(*), intent(in) :: notes
    real(dp), intent(in) :: seconds(:)                   !! (stages)
    type(error_type), allocatable, intent(inout) :: error
    if (self%body%known()) then
      call self%body%complete(unfinished%head_path(), error)
      call open_result(unfinished%result_path(), self%file, error)
    end if
    if (.not. allocated(error)) call self%file%finish(notes, seconds, error)
  end subroutine finish

  subroutine abandon(self, unfinished)
    !! What has no places of its own is made again from the records.
    class(assembly_type), intent(inout) :: self
    type(unfinished_work), intent(in) :: unfinished
    if (.not. allocated(self%done) .or. self%body%known()) return      ! it was never begun, or its cases lie there
    call self%file%close()
    call unfinished%remove_result()
  end subroutine abandon

end module bw_assembly
